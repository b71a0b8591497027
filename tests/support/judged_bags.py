"""What a recorder leaves, held against what was said: every bag is whole, or can be made so."""

from collections import Counter
from pathlib import Path

from bdt_bags.bag_error import BagError
from bdt_bags.reading.bag_reader import read_bag
from bdt_bags.recovery.recover_bag import recover_bag

NOTHING = (
    "does not exist",
    "holds no message",
    "holds no .mcap",
    "have no messages",
    "has no messages",
)
"""How a bag is refused that a recorder had not begun, or just begun, when it was killed."""


def wrong_with_bag(folder: Path, said: dict[str, Counter[bytes]], *, was_killed: bool) -> str:
    """Return what is wrong with a bag; empty if nothing is.

    Parameters
    ----------
    folder : Path
        The bag.
    said : dict of str to Counter of bytes
        How often each message was said, by topic name.
    was_killed : bool
        Whether its recorder was killed: then it may have to be recovered first, and holds what
        was said until shortly before.
    """
    try:
        if was_killed:
            folder = recover_bag(folder).output
        bag = read_bag(folder)
    except BagError as error:
        is_nothing = was_killed and any(text in str(error) for text in NOTHING)
        return "" if is_nothing else str(error)
    for topic, raw in bag.topics.items():
        if topic.name in said and (strange := Counter(raw.data) - said[topic.name]):
            return f"{folder.name}: {strange.total()} messages of {topic.name} nobody has said"
    return ""


def lost_by_recorder(folder: Path, said: dict[str, Counter[bytes]]) -> str:
    """Tell of what is missing between the first and the last message of a topic; empty if none is.

    Parameters
    ----------
    folder : Path
        Bag of a recorder that nothing happened to.
    said : dict of str to Counter of bytes
        How often each message was said, by topic name, in the order in which it was said first.
    """
    for topic, raw in read_bag(folder).topics.items():
        if topic.name not in said or not topic.reliable:
            continue
        order = list(said[topic.name])
        first, last = order.index(raw.data[0]), order.index(raw.data[-1])
        missing = set(order[first : last + 1]) - set(raw.data)
        if missing:
            return f"{folder.name}: {len(missing)} messages of {topic.name} are missing"
    return ""
