"""Every console block of the tutorials runs, in order, and prints what the page says."""

import pytest
from typed_tutorials import IN_REAL_TIME, PAGES, run_tutorial


@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if page.stem not in IN_REAL_TIME],
    ids=lambda page: page.stem,
)
def test_a_tutorial_prints_what_it_shows(page, folder, environment):
    run_tutorial(page, folder, environment)


def test_a_page_that_shows_something_else_fails_with_the_difference(tmp_path, environment):
    page = tmp_path / "page.md"
    page.write_text("```console\n$ echo 1; echo 2\n1\n3\n```\n", encoding="utf-8")
    with pytest.raises(pytest.fail.Exception, match=r"block at line 1.*\n(.*\n)*.*- 3\n.*\+ 2"):
        run_tutorial(page, tmp_path, environment)


def test_a_command_that_fails_makes_the_tutorial_fail(tmp_path, environment):
    page = tmp_path / "page.md"
    page.write_text("```console\n$ false\n$ echo $?\n1\n$ false\n```\n", encoding="utf-8")
    with pytest.raises(pytest.fail.Exception, match=r"\$ false\nexit code 1"):
        run_tutorial(page, tmp_path, environment)


def test_a_command_keeps_running_until_its_terminal_goes_on(tmp_path, environment):
    page = tmp_path / "page.md"
    second = "```{code-block} console\n:caption: Terminal 2\n"
    text = "\n".join(
        [
            "```console\n$ mkfifo pipe\n```",
            second + "$ echo begin; cat pipe\nbegin\n```",
            "```console\n$ echo end > pipe\n```",
            second + "end\n$ sh -c 'echo ready; exec sleep 1000'\nready\n```",
            second + "^C\n```",
        ]
    )
    page.write_text(text, encoding="utf-8")
    run_tutorial(page, tmp_path, environment)
