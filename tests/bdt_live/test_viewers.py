"""Pages that are open: what a slow one misses, and how it comes back."""

import asyncio
import json

from bdt_live.viewers import HISTORY, MOST_WAITING, History, Viewers


def test_a_page_that_comes_begins_with_the_history():
    async def story():
        viewer = Viewers().add()
        return await viewer.next()

    assert asyncio.run(story()) is None


def test_a_page_gets_what_comes_after_that_in_its_order():
    async def story():
        viewers = Viewers()
        viewer = viewers.add()
        await viewer.next()
        for text in "abc":
            viewers.tell(text)
        return [await viewer.next() for _ in range(3)]

    assert asyncio.run(story()) == ["a", "b", "c"]


def test_a_page_that_was_suspended_begins_anew_instead_of_catching_up():
    async def story():
        viewers = Viewers()
        viewer, other = viewers.add(), viewers.add()
        await viewer.next()
        await other.next()
        for number in range(10 * MOST_WAITING):
            viewers.tell(str(number))
            assert await other.next() == str(number)
        again = await viewer.next()
        viewers.tell("new")
        return again, await viewer.next()

    assert asyncio.run(story()) == (None, "new")


def test_a_reply_is_for_the_page_that_asked():
    async def story():
        viewers = Viewers()
        pages = [viewers.add(), viewers.add()]
        for page in pages:
            await page.next()
        viewers.tell("answer", pages[1].number)
        viewers.tell("answer to one that is gone", 99)
        viewers.tell("all")
        return [await page.next() for page in pages]

    assert asyncio.run(story()) == ["all", "answer"]


def test_the_history_is_a_minute_and_no_more():
    history = History()
    for tenth in range(2000):
        history.add(tenth / 10, f'{{"rows":[[{tenth / 10}]]}}')
    times = [frame["rows"][0][0] for frame in json.loads(history.text())["frames"]]
    assert times[-1] == 199.9
    assert times[0] == 199.9 - HISTORY


def test_time_that_goes_back_begins_another_history():
    history = History()
    history.add(50.0, '"old"')
    history.add(0.0, '"new"')
    assert json.loads(history.text())["frames"] == ["new"]
