"""What the process of the page says to the process behind it."""

import json
from typing import Any

from bdt_live.page_requests import PageRequest, read_request


def page_has_come() -> dict[str, Any]:
    """Return the message that a page has come, which has to hear everything from the beginning."""
    return {"page": 0, "request": None}


def page_asks(page: int, text: str) -> dict[str, Any]:
    """Return the message with what a page asks for.

    Parameters
    ----------
    page : int
        Number of the page, which the reply carries.
    text : str
        A request that :func:`bdt_live.page_requests.read_request` takes.
    """
    return {"page": page, "request": text}


def read_server_message(text: str) -> tuple[int, PageRequest | None]:
    """Return the number of a page and its request; None for a page that has come."""
    message = json.loads(text)
    request = message["request"]
    return message["page"], None if request is None else read_request(request)
