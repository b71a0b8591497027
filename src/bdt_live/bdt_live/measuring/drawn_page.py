"""What somebody in front of a page sees: how soon a dragged slider shows, how often it draws."""

import time

from bdt_live.measuring.chromium import Chromium

FEWEST, MOST = 20, 380
"""Steps of the slider's 400 between which it is dragged."""

DRAG = """
new Promise((done) => {
  const slider = document.querySelector("[aria-label='plant.gap.initial, slider']");
  slider.value = Number(slider.min) + %d * Number(slider.step);
  const words = `gap ${(Number(slider.value) * 180 / Math.PI).toFixed(2)}°`;
  const canvas = CanvasRenderingContext2D.prototype;
  const { fillText } = canvas;
  const begin = performance.now();
  canvas.fillText = function (text, ...place) {
    fillText.call(this, text, ...place);
    if (text !== words) return;
    canvas.fillText = fillText;
    requestAnimationFrame(() => done((performance.now() - begin) / 1e3));
  };
  slider.dispatchEvent(new Event("input", { bubbles: true }));
})
"""
"""Drags the gap and waits for the picture after the one in which the mechanism has its number."""

FRAMES = "Number(document.documentElement.dataset.frames)"


def time_to_drawing(browser: Chromium, turn: int) -> float:
    """Drag the slider of the gap, and return the time until the mechanism is drawn with it [s].

    Parameters
    ----------
    browser : Chromium
        With the page of a loop.
    turn : int
        How often this was done before: each drag is a long one, to another place.
    """
    # Even steps are multiples of 0.15°, which no rounding of two decimals takes for others.
    steps = FEWEST + 2 * (turn * 89 % ((MOST - FEWEST) // 2))
    return float(browser.evaluate(DRAG % steps))


def picture_rate(browser: Chromium, duration: float) -> float:
    """Return how often a page is drawn within a wall time [s], in pictures a second."""
    before, begin = browser.evaluate(FRAMES), time.monotonic()
    browser.evaluate(f"new Promise((done) => setTimeout(done, {1e3 * duration}))")
    return float(browser.evaluate(FRAMES) - before) / (time.monotonic() - begin)
