"""Expansion of topic and service names."""

from embedded_ros.names import expand


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Make a name absolute.

    Parameters
    ----------
    topic_name : str
        Relative, private (``~/x``), with substitutions (``{node}``) or absolute.
    node_name, node_namespace : str
        The node that uses the name.
    """
    return expand(topic_name, node_name, node_namespace)
