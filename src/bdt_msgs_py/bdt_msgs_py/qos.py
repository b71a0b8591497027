"""Quality of service of a topic as the profile that rclpy wants."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from bdt_msgs_py.topics import Topic


def qos_profile(topic: Topic, depth: int | None = None) -> QoSProfile:
    """Return the QoS profile of `topic`.

    Parameters
    ----------
    topic : Topic
        One of :data:`bdt_msgs_py.topics.ALL_TOPICS`.
    depth : int, optional
        Longer history for one endpoint, for example a recorder's; the default is the topic's.

    Returns
    -------
    rclpy.qos.QoSProfile
    """
    reliable, best_effort = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
    transient, volatile = DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=topic.depth if depth is None else depth,
        reliability=reliable if topic.reliable else best_effort,
        durability=transient if topic.transient_local else volatile,
    )


def publisher_profile(topic: Topic) -> QoSProfile:
    """Return the QoS profile for a publisher of `topic`: its history is that of what is kept.

    Parameters
    ----------
    topic : Topic
        One of :data:`bdt_msgs_py.topics.ALL_TOPICS`.

    Returns
    -------
    rclpy.qos.QoSProfile
    """
    return qos_profile(topic, max(topic.depth, topic.kept))
