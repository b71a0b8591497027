"""The pages as people use them: opened from disk in a browser that has no network."""

import pytest
from recorded_loops import Messages, ros, stamp

from bdt_analysis.analyze import analyze
from bdt_msgs_py.topics import MARK

PANELS = 4
SHOWN = (
    "(({begin, end}) => [Number(begin), Number(end)])(document.getElementById('time-plot').dataset)"
)
X_RANGES = "document.getElementById('time-plot')._fullLayout.xaxis.range.map(Number)"


def visible_times(browser) -> list[list[float]]:
    """Return first and last drawn time of each curve."""
    return browser.evaluate(
        "document.getElementById('time-plot').data.map((t) => [t.x[0], t.x[t.x.length - 1]])"
    )


@pytest.mark.parametrize(
    ("page", "scheme", "width"),
    [
        ("report", "light", 1200),
        ("report", "dark", 380),
        ("comparison", "dark", 1200),
        ("comparison", "light", 380),
    ],
)
def test_plots_are_drawn_without_complaint_and_without_network(
    browser, request, page, scheme, width
):
    browser.open(request.getfixturevalue(page), width=width, scheme=scheme)
    assert browser.evaluate("document.documentElement.dataset.plots") == "drawn"
    assert browser.complaints() == []
    subplots = (
        "new Set([...document.querySelectorAll('#time-plot .subplot')]"
        ".map((plot) => plot.classList[1])).size"
    )
    assert browser.evaluate(subplots) == PANELS
    drawn = (
        "[...document.querySelectorAll('#time-plot .lines path')]"
        ".filter((path) => path.getTotalLength() > 100).length"
    )
    assert browser.evaluate(drawn) >= 5
    assert browser.evaluate("document.querySelectorAll('#cycle-plot .lines path').length") >= 2
    # Nothing sticks out of the page at the width of a telephone.
    assert browser.evaluate("document.documentElement.scrollWidth") <= width


def test_dragging_in_one_plot_zooms_all_of_them(browser, report):
    browser.open(report)
    before = browser.evaluate(SHOWN)
    box = browser.evaluate(
        "(() => { const r = document.querySelector('#time-plot .nsewdrag').getBoundingClientRect();"
        " scrollBy(0, r.top - 100); const s = document.querySelector('#time-plot .nsewdrag')"
        ".getBoundingClientRect(); return [s.left, s.top, s.width, s.height]; })()"
    )
    left, top, width, height = box
    middle = top + height / 2
    browser.drag((left + 0.25 * width, middle), (left + 0.5 * width, middle))
    browser.wait_for(f"{SHOWN}[0] > 1")
    begin, end = browser.evaluate(SHOWN)
    span = before[1] - before[0]
    assert begin == pytest.approx(before[0] + 0.25 * span, abs=0.01 * span)
    assert end == pytest.approx(before[0] + 0.5 * span, abs=0.01 * span)
    assert browser.evaluate(X_RANGES) == pytest.approx([begin, end])
    for first, last in visible_times(browser):
        assert first == pytest.approx(begin, abs=10.0)
        assert last <= end + 10.0
    assert browser.evaluate("location.hash").startswith("#t=")


def test_an_address_leads_to_a_moment(browser, report):
    browser.open(report, "#t=10,10.5")
    assert browser.evaluate(SHOWN) == [10, 10.5]
    assert browser.evaluate(X_RANGES) == [10, 10.5]
    note = browser.evaluate("document.getElementById('decimation').textContent")
    assert "10 s to 10.5 s." in note
    assert "This view draws all of them that lie in it." in note


def test_a_click_on_a_step_shows_it_in_both_figures(browser, report):
    browser.open(report)
    browser.evaluate("document.querySelector('tr[data-step=\"3\"]').click()")
    browser.wait_for("location.hash === '#step=3'")
    assert browser.evaluate(SHOWN) == pytest.approx([10, 15])
    assert browser.evaluate("document.getElementById('cycle-plot').dataset.step") == "3"
    assert "End of step 3" in browser.evaluate("document.getElementById('cycle-title').textContent")
    browser.evaluate("document.getElementById('step-end').click()")
    browser.wait_for("location.hash === '#step=3,end'")
    assert browser.evaluate(SHOWN) == pytest.approx([12.5, 15])
    browser.evaluate("document.getElementById('whole').click()")
    browser.wait_for(f"{SHOWN}[0] === 0")
    assert browser.evaluate(SHOWN)[1] == pytest.approx(20, abs=1e-3)


def test_marks_are_lines_in_every_panel(browser, small_loop, tmp_path):
    marked = Messages(list(small_loop.items), small_loop.namespace)
    marked.add(MARK, 1.5, ros("std_msgs/msg/Header", stamp=stamp(1.5), frame_id="live"))
    analyze(marked.write(tmp_path / "bag"), tmp_path)
    browser.open(tmp_path / "report.html")
    lines = "document.querySelectorAll('#time-plot .shapelayer path[style*=\"dasharray\"]').length"
    assert browser.evaluate(lines) == PANELS


def test_a_view_keeps_the_extremes(browser, report):
    """What is drawn of the whole run has the extremes of what the page holds, which is float32."""
    browser.open(report)
    kept = browser.evaluate("""(() => {
        const plot = document.getElementById('time-plot');
        const description = JSON.parse(document.getElementById('description').textContent);
        return loadSignals(description).then(() => description.series.map((series, k) => {
            const range = (values) => values.reduce(
                ([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
            return [range([...series.value]), range([...plot.data[k].y]), plot.data[k].y.length];
        }));
    })()""")
    for held, drawn, _ in kept:
        assert drawn == held
    assert max(count for _, _, count in kept) < 6000


def test_the_theme_follows_the_system_until_the_button_is_pressed(browser, report):
    background = "getComputedStyle(document.body).backgroundColor"
    browser.open(report, scheme="dark")
    dark = browser.evaluate(background)
    line = "document.getElementById('time-plot').data[0].line.color"
    dark_line = browser.evaluate(line)
    browser.evaluate("document.getElementById('theme').click()")
    browser.wait_for(f"{line} !== {dark_line!r}")
    assert browser.evaluate(background) != dark
    assert browser.evaluate("document.getElementById('theme').textContent") == "Dark"
    browser.evaluate("localStorage.clear()")


def test_a_table_is_copied_as_plain_numbers(browser, report):
    browser.open(report)
    text = browser.evaluate("tabSeparated(document.getElementById('steps'))")
    head, *rows = text.splitlines()
    assert head.split("\t")[:4] == ["step", "begins [s]", "r [mm]", "residual, peak to peak [µm]"]
    assert [float(row.split("\t")[1]) for row in rows] == [0, 5, 10, 15]
    assert all(float(cell) is not None for cell in rows[2].split("\t")[:6])
    assert browser.evaluate("!document.querySelector('[data-copies=steps]').hidden")


def test_without_plots_the_pictures_stay(browser, report, tmp_path):
    broken = tmp_path / "broken.html"
    text = report.read_text(encoding="utf-8")
    broken.write_text(text.replace('id="signals">', 'id="signals">A', 1), encoding="utf-8")
    browser.open(broken)
    assert browser.evaluate("document.documentElement.dataset.plots") == "failed"
    assert (
        browser.evaluate("document.querySelector('.static svg').getBoundingClientRect().height")
        > 100
    )
    assert not browser.evaluate("document.getElementById('plots-failed').hidden")
