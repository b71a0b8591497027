"""What a node has made, by kind."""

from collections.abc import Iterator
from enum import IntEnum
from typing import Any

__all__ = ["EntityRegistry", "Kind"]


class Kind(IntEnum):
    """Kinds of entities, those with work in the order in which a node serves them."""

    EVENTS = 0
    TIMER = 1
    SUBSCRIPTION = 2
    GUARD_CONDITION = 3
    CLIENT = 4
    SERVICE = 5
    PUBLISHER = 6


class EntityRegistry:
    """The entities of a node by kind, each kind in the order of creation."""

    def __init__(self) -> None:
        self._by_kind: tuple[list[Any], ...] = tuple([] for _ in Kind)

    def add(self, kind: Kind, entity: Any) -> None:
        """Enter an entity."""
        self._by_kind[kind].append(entity)

    def remove(self, kind: Kind, entity: Any) -> bool:
        """Remove an entity; False if there is none."""
        entities = self._by_kind[kind]
        if entity not in entities:
            return False
        entities.remove(entity)
        return True

    def of(self, kind: Kind) -> Iterator[Any]:
        """Iterate over the entities of a kind, as they are now."""
        return iter(tuple(self._by_kind[kind]))

    def sources(self) -> Iterator[Any]:
        """Iterate over what has work for an executor besides events, in the order of serving."""
        for entities in self._by_kind[Kind.TIMER : Kind.PUBLISHER]:
            yield from tuple(entities)

    def empty(self) -> Iterator[Any]:
        """Remove everything, piece by piece: other threads may remove, too."""
        for kind, entities in zip(Kind, self._by_kind, strict=True):
            while entities:
                entity = entities.pop()
                if kind is not Kind.EVENTS:
                    yield entity
