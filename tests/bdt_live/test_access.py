"""Who may see the page."""

import pytest

from bdt_live.access import Access


@pytest.fixture
def access():
    return Access("127.0.0.1", 8765)


def test_every_server_has_secrets_of_its_own(access):
    other = Access("127.0.0.1", 8765)
    assert access.token != other.token
    assert access.session not in (other.session, access.token)
    assert len(access.token) >= 32


def test_secrets_stay_out_of_what_is_printed_of_an_object(access):
    assert access.token not in repr(access)
    assert access.session not in repr(access)


def test_the_address_has_the_token(access):
    assert access.address == f"http://127.0.0.1:8765/?token={access.token}"


@pytest.mark.parametrize("given", ["", "x", "ü", "\udcff"])
def test_no_text_but_the_secret_opens(access, given):
    assert not access.is_token(given)
    assert not access.is_session(given)
    assert not access.is_password(given)
    assert access.is_token(access.token)
    assert access.is_session(access.session)


def test_without_a_password_no_password_is_right(access):
    assert not access.is_password("")
    assert Access("10.0.0.7", 80, "correct horse").is_password("correct horse")


def test_a_name_that_points_here_is_not_this_server(access):
    assert access.is_host("localhost:8765")
    assert not access.is_host("evil.example:8765")
    assert not access.is_host("127.0.0.1:8766")
    assert not access.is_host(None)


def test_the_page_of_another_origin_is_not_ours(access):
    assert access.is_origin("http://127.0.0.1:8765")
    for origin in (
        None,
        "null",
        "http://evil.example",
        "http://127.0.0.1",
        "https://127.0.0.1:8765",
    ):
        assert not access.is_origin(origin)
