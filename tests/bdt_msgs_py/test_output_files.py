"""Files are tried before the work that they are the result of, and left as they were."""

import pytest

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.output_files import PICTURES, prepare_output, real_path


def test_a_new_file_is_not_left_behind_but_its_folder_is(tmp_path):
    prepare_output("--figure", tmp_path / "new" / "a.png", PICTURES)
    assert list((tmp_path / "new").iterdir()) == []


def test_a_file_that_exists_stays_as_it_is(tmp_path):
    (tmp_path / "a.html").write_text("old")
    prepare_output("--output", tmp_path / "a.html")
    assert (tmp_path / "a.html").read_text() == "old"


@pytest.mark.parametrize("name", ["a", "a.bmp", "png"])
def test_another_ending_is_refused(tmp_path, name):
    with pytest.raises(BadInputError, match=r"must end with \.png, \.svg or \.pdf"):
        prepare_output("--figure", tmp_path / name, PICTURES)


def test_a_folder_and_a_file_in_place_of_a_folder_are_refused(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path, tmp_path / "file" / "a.html"):
        with pytest.raises(BadInputError, match=f"--output {path}: cannot be written: "):
            prepare_output("--output", path)


def test_links_in_a_circle_have_a_path(tmp_path):
    (tmp_path / "a").symlink_to(tmp_path / "a")
    assert real_path(tmp_path / "a").name == "a"
