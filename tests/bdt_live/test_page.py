"""The page of `bdt live` in a real browser, on a loop that runs.

The tests share one loop and one page, and leave both as they found them.
"""

import json
import os
import re
import signal
import time
from pathlib import Path

import pytest

from bdt_bags.reading.recording import load_recording
from bdt_live.extremes import COLUMNS

DEADLINE = 120.0
"""Wall time [s] after which a condition counts as never met."""

GAP = "plant.gap.initial"


def value_of(page, control):
    return page.evaluate(f"Number(document.getElementById('{control}').value)")


def type_into(page, control, text):
    page.evaluate(
        f"(() => {{ const field = document.getElementById('{control}');"
        f"field.focus(); field.value = {json.dumps(text)};"
        "field.dispatchEvent(new Event('change', {bubbles: true})); })()"
    )


def press(page, key, focus="document.body"):
    page.evaluate("document.activeElement.blur()")
    page.evaluate(f"{focus}.focus()")
    for kind in ("keyDown", "keyUp"):
        page.command(
            "Input.dispatchKeyEvent", type=kind, key=key, text=key if len(key) == 1 else ""
        )


def seconds(page):
    return float(page.evaluate("document.getElementById('time').textContent").split()[0])


def wait_until_shown(page, text, where="log"):
    page.wait_for(f"document.getElementById('{where}').textContent.includes({json.dumps(text)})")


def test_columns_are_those_of_the_rows():
    source = (Path(__file__).parents[2] / "src/bdt_live/bdt_live/page/signals.js").read_text()
    listed = re.search(r"COLUMNS = \[(.*?)\]", source, re.DOTALL)[1]
    assert tuple(re.findall(r'"(\w+)"', listed)) == COLUMNS


def test_what_somebody_sets_is_shown_at_its_newest_and_the_rest_evenly(page):
    """Rows come in batches: what moves is shown a little late, so that it does not jump."""
    shown = page.evaluate(
        "import('./page/signals.js').then(({Signals, COLUMNS}) => {"
        "const signals = new Signals();"
        "const row = (time, value) => COLUMNS.map((name) => name === 'time' ? time : value);"
        "signals.add([row(1.0, 1), row(1.01, 2), row(1.02, 3)]);"
        "signals.shown = 1.005;"
        "return signals.now(); })"
    )
    assert shown["gap"] == shown["dead_zone"] == 3
    assert shown["q1"] == pytest.approx(1.5)
    assert shown["estimate"] == 1


def test_the_page_loads_from_this_server_alone_and_complains_of_nothing(page, live_loop):
    origin = live_loop.address.split("?")[0]
    begin = seconds(page)
    page.wait_for(f"parseFloat(document.getElementById('time').textContent) > {begin + 1}")
    assert [each for each in page.complaints() if not each.startswith(origin)] == []
    assert page.evaluate("location.href") == origin


def test_the_mechanism_and_every_plot_is_drawn(page):
    painted = """[...document.querySelectorAll('canvas')].map((canvas) => {
        const {width, height} = canvas;
        const data = canvas.getContext('2d').getImageData(0, 0, width, height).data;
        return data.some((value) => value !== 0);
    })"""
    page.wait_for(f"({painted}).length === 7 && ({painted}).every((each) => each)")


def test_the_last_minute_is_saved_as_a_bag_with_a_report(page, live_loop):
    """Early, for a report of a few seconds takes less time than one of a minute."""
    press(page, "m", focus="document.getElementById('save')")
    wait_until_shown(page, "marked at")
    page.evaluate("document.getElementById('save').click()")
    wait_until_shown(page, "saved bag-")
    (bag,) = live_loop.output.glob("bag-*")
    assert (bag / "metadata.yaml").is_file()
    wait_until_shown(page, "report of bag-")
    assert len(load_recording(bag).marks) == 1
    link = page.evaluate("document.querySelector('#log a').href")
    body = page.evaluate(f"fetch({json.dumps(link)}).then((answer) => answer.text())")
    assert "Dotted lines are marks, at " in body


def test_a_dragged_gap_reaches_the_plant(page):
    box = page.evaluate(
        f"(() => {{ const box = document.getElementById('{GAP}').parentElement"
        ".querySelector('input[type=range]').getBoundingClientRect();"
        "return [box.left, box.top, box.width, box.height]; })()"
    )
    left, top, width, height = box
    begin = (left + 8, top + height / 2)
    page.drag(begin, (left + width / 2, top + height / 2))
    page.wait_for(f"document.getElementById('{GAP}').value > 10")
    assert 12.0 < value_of(page, GAP) < 18.0


def test_a_value_that_a_node_refuses_shows_its_reason_and_goes_back(page):
    control = "controller.pid.filter_time"
    before = value_of(page, control)
    type_into(page, control, "-1")
    reason = f"document.getElementById('{control}').closest('.control').querySelector('.reason')"
    page.wait_for(f"!{reason}.hidden")
    assert "filter_time" in page.evaluate(f"{reason}.textContent")
    assert value_of(page, control) == before
    type_into(page, control, str(before))
    page.wait_for(f"{reason}.hidden")


def test_somebody_else_s_change_moves_the_slider(page, live_loop):
    control = "controller.pid.integral"
    before = value_of(page, control)
    live_loop.ros2("param", "set", "/controller", "pid.integral", "20000.0")
    page.wait_for(f"document.getElementById('{control}').value === '20000'")
    type_into(page, control, str(before))
    page.wait_for(f"document.getElementById('{control}').value === '{before:.0f}'")


def test_a_dead_zone_is_taken_over_from_the_twin_and_given_back(page):
    twin = "document.getElementById('twin.reconfigure')"
    type_into(page, "controller.dead_zone_tolerance", "40")
    page.wait_for(f"!{twin}.checked")
    page.wait_for("document.getElementById('controller.dead_zone_tolerance').value === '40'")
    page.evaluate(f"{twin}.click()")
    page.wait_for(f"{twin}.checked")
    page.wait_for("document.getElementById('controller.dead_zone_tolerance').value !== '40'")


def test_the_loop_waits_makes_a_step_and_goes_on(page):
    press(page, " ")
    page.wait_for("document.getElementById('pause').getAttribute('aria-pressed') === 'true'")
    page.wait_for("!document.getElementById('step').disabled")
    settled = "new Promise((done) => setTimeout(() => done(true), 300))"
    page.evaluate(settled)
    before = seconds(page)
    press(page, ".")
    page.wait_for(f"parseFloat(document.getElementById('time').textContent) > {before}")
    page.evaluate(settled)
    assert 0.02 <= seconds(page) - before <= 0.13
    press(page, " ")
    page.wait_for("document.getElementById('pause').getAttribute('aria-pressed') === 'false'")
    page.wait_for(f"parseFloat(document.getElementById('time').textContent) > {before + 0.5}")


def choose_pace(page, value):
    page.evaluate(
        f"(() => {{ const pace = document.getElementById('pace'); pace.value = '{value}';"
        "pace.dispatchEvent(new Event('change')); })()"
    )


def test_the_loop_goes_at_the_pace_that_is_chosen(page):
    choose_pace(page, "0.1")
    page.wait_for("parseFloat(document.getElementById('rate').textContent) < 100")
    choose_pace(page, "1")
    page.wait_for("parseFloat(document.getElementById('rate').textContent) > 300")


def test_a_pace_that_somebody_else_has_set_is_shown(page, live_loop):
    shown = "parseFloat(document.getElementById('pace').selectedOptions[0]?.textContent)"
    live_loop.ros2("param", "set", "/plant", "pace", "0.3")
    page.wait_for(f"{shown} === 0.3")
    choose_pace(page, "1")
    page.wait_for("document.getElementById('pace').options.length === 7")
    assert page.evaluate(shown) == 1


def test_the_slider_of_the_gap_follows_one_that_wears(page):
    page.evaluate("document.activeElement.blur()")
    page.evaluate("document.getElementById('wear').click()")
    before = value_of(page, GAP)
    page.wait_for(f"document.getElementById('{GAP}').value > {before + 1.0}")


def test_a_preset_is_one_click_or_the_number_of_its_figure(page):
    page.evaluate("document.querySelector('[data-preset=linear]').click()")
    page.wait_for("!document.getElementById('twin.reconfigure').checked")
    page.wait_for("document.getElementById('controller.dead_zone_tolerance').value === '0'")
    press(page, "7")
    page.wait_for("document.getElementById('twin.reconfigure').checked")


def frames_go_on(page):
    frames = "Number(document.documentElement.dataset.frames)"
    page.wait_for(f"{frames} > {page.evaluate(frames) + 5}")


def test_a_node_that_hangs_is_told_and_what_it_is_asked_for_is_given_up(page, live_loop):
    (twin,) = live_loop.processes("bdt_twin.twin_node")
    os.kill(twin, signal.SIGSTOP)
    try:
        type_into(page, "twin.communication_delay", "0.5")
        wait_until_shown(page, "has not answered within 2 s", "controls")
        wait_until_shown(page, "silent for", "nodes")
        frames_go_on(page)
    finally:
        os.kill(twin, signal.SIGCONT)
    page.wait_for("!document.getElementById('nodes').textContent.includes('silent for')")
    type_into(page, "twin.communication_delay", "1")
    page.wait_for("!document.getElementById('controls').textContent.includes('not answered')")


def test_a_killed_controller_is_started_anew_while_the_page_goes_on(page, live_loop):
    (before,) = live_loop.processes("bdt_controller.controller_node")
    os.kill(before, signal.SIGKILL)
    frames_go_on(page)
    end = time.monotonic() + DEADLINE
    while live_loop.processes("bdt_controller.controller_node") in ([], [before]):
        assert time.monotonic() < end
        frames_go_on(page)
    page.wait_for(f"parseFloat(document.getElementById('time').textContent) > {seconds(page) + 1}")


def test_a_lost_connection_comes_back_with_what_was_before(page):
    count = page.evaluate("window.sockets.length")
    page.evaluate("window.sockets.at(-1).close()")
    page.wait_for(f"window.sockets.length > {count} && window.sockets.at(-1).readyState === 1")
    page.wait_for(f"parseFloat(document.getElementById('time').textContent) > {seconds(page)}")


def test_a_letter_that_is_typed_into_a_field_is_no_key_of_the_page(page):
    marks = "document.getElementById('log').textContent.split('marked at').length"
    before = page.evaluate(marks)
    press(page, "m", focus=f"document.getElementById('{GAP}')")
    frames_go_on(page)
    assert page.evaluate(marks) == before


def test_a_page_that_the_server_does_not_know_says_what_to_do(page, live_loop):
    """As after a restart: the token is another one, and so is the cookie."""
    page.command("Network.clearBrowserCookies")
    page.evaluate("window.sockets.at(-1).close()")
    wait_until_shown(page, "was started anew", "banner")
    page.go(live_loop.address)
    page.wait_for("document.getElementById('state')?.dataset.word === 'ok'")
    assert page.evaluate("document.getElementById('banner').hidden")


@pytest.mark.parametrize("width", [375, 800])
def test_on_a_narrow_screen_nothing_sticks_out(page, width):
    page.resize(width, 800)
    page.wait_for(f"document.documentElement.scrollWidth <= {width}")


LONG_NAME = "a_driver_with_a_very_long_name_of_its_own"


@pytest.mark.parametrize("width", [375, 1500])
def test_a_node_with_a_long_name_covers_nothing(page, width):
    page.resize(width, 950)
    node = {"name": LONG_NAME, "level": 0, "text": "driving", "age": 0.1}
    state = {"type": "state", "word": "ok", "cause": "", "reason": "", "nodes": [node]}
    state |= {"rate": None, "latency": None, "pace": 1.0, "paused": False}
    heard = f"new MessageEvent('message', {{ data: {json.dumps(json.dumps(state))} }})"
    # Within one step of the page: half a second later the loop tells its own nodes again.
    name_end, text_begin, text_end, panel_end = page.evaluate(
        f"(() => {{ window.sockets.at(-1).dispatchEvent({heard});"
        "const panel = document.getElementById('nodes');"
        "const [name, text] = panel.querySelectorAll('span');"
        "const range = document.createRange(); range.selectNodeContents(name);"
        "return [range.getBoundingClientRect().right, text.getBoundingClientRect().left,"
        "text.getBoundingClientRect().right, panel.getBoundingClientRect().right]; })()"
    )
    assert name_end <= text_begin
    assert text_end <= panel_end


def test_what_buttons_set_is_no_slider(page):
    assert page.evaluate("document.getElementById('plant.pause_at')") is None
    assert page.evaluate("document.getElementById('plant.gap.kind')") is not None
