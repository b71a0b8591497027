"""The browser that does what it is told, and what is measured in front of its page."""

import struct

import pytest

from bdt_live.measuring.chromium import ChromiumError
from bdt_live.measuring.drawn_page import picture_rate, time_to_drawing

DELAY = 0.1
"""Wall time [s] after which the page below draws what its slider says."""

PAGE = """
<!doctype html><html data-frames="0"><body><canvas></canvas>
<input type="range" aria-label="plant.gap.initial, slider" min="0" max="0.5236" step="0.001309">
<script>
  const slider = document.querySelector("input");
  const context = document.querySelector("canvas").getContext("2d");
  let shown = 0;
  slider.addEventListener("input", () => {
    setTimeout(() => { shown = Number(slider.value); }, 1000 * %f);
  });
  (function draw() {
    requestAnimationFrame(draw);
    document.documentElement.dataset.frames = Number(document.documentElement.dataset.frames) + 1;
    context.fillText(`gap ${(shown * 180 / Math.PI).toFixed(2)}°`, 0, 20);
  })();
</script></body></html>
"""


@pytest.fixture
def page(browser, tmp_path):
    file = tmp_path / "page.html"
    file.write_text(PAGE % DELAY)
    browser.go(file.as_uri())
    browser.wait_for("Boolean(document.querySelector('canvas'))")
    return browser


def test_a_promise_is_awaited_and_what_throws_is_an_error(page):
    assert page.evaluate("new Promise((done) => setTimeout(() => done(7), 1))") == 7
    with pytest.raises(ChromiumError, match="not a number"):
        page.evaluate("(() => { throw new Error('not a number'); })()")


def test_what_chromium_does_not_know_or_a_page_does_not_become_is_an_error(page):
    with pytest.raises(ChromiumError, match=r"Page\.fly"):
        page.command("Page.fly")
    with pytest.raises(ChromiumError, match=r"not within 0\.1 s: false"):
        page.wait_for("false", deadline=0.1)


def test_a_picture_has_the_size_of_the_page(page):
    page.resize(320, 200)
    assert struct.unpack(">II", page.picture()[16:24]) == (320, 200)


def test_a_drag_takes_until_the_picture_that_shows_it(page):
    for turn in range(3):
        assert DELAY <= time_to_drawing(page, turn) < 10.0


def test_pictures_are_counted(page):
    assert 1.0 < picture_rate(page, 0.2) < 200.0
