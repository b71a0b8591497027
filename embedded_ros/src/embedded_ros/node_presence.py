"""A node as the network sees it."""

from typing import Protocol

from embedded_ros.endpoints import Reader, Writer
from embedded_ros.session import Session

__all__ = ["NodePresence"]


class _Closeable(Protocol):
    """What lives in the network."""

    def close(self) -> None:
        """Leave the network. Again is fine."""
        ...


class NodePresence:
    """Name and endpoints of a node.

    It knows nothing of the node's object, so that a node that is just dropped can be taken out of
    the network by a finalizer that holds this.

    Parameters
    ----------
    session : Session
        Kept open until :meth:`end`.
    name, namespace : str
    """

    def __init__(self, session: Session, name: str, namespace: str) -> None:
        self._session = session
        self._closeables: set[_Closeable] = set()
        session.acquire()
        #: The node's entry in the graph.
        self.entry = session.graph.add_node(name, namespace)

    def enter(self, *endpoints: Writer | Reader) -> None:
        """Show endpoints in the graph."""
        self._closeables.update(endpoints)
        self._session.graph.add(self.entry, **_guids(endpoints))

    def leave(self, *endpoints: Writer | Reader) -> None:
        """Show endpoints in the graph no more."""
        self._closeables.difference_update(endpoints)
        self._session.graph.remove(self.entry, **_guids(endpoints))

    def own(self, closeable: _Closeable) -> None:
        """Close something with the node that enters the graph by itself."""
        self._closeables.add(closeable)

    def end(self) -> None:
        """Close everything and leave the graph."""
        for closeable in self._closeables:
            closeable.close()
        self._session.graph.remove_node(self.entry)
        self._session.release()


def _guids(endpoints: tuple[Writer | Reader, ...]) -> dict[str, tuple[bytes, ...]]:
    writers, readers = (
        tuple(endpoint.guid for endpoint in endpoints if isinstance(endpoint, type_))
        for type_ in (Writer, Reader)
    )
    return {"writers": writers, "readers": readers}
