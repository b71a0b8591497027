"""What a bag knows about a topic and about a message, whatever its storage."""

from dataclasses import dataclass
from typing import NamedTuple

from rosbags.typesys import Stores, get_typestore


class BagWriteError(Exception):
    """The disk refuses to take more; one line. What was to be written is kept for another try."""


@dataclass(frozen=True)
class TopicMetadata:
    """A topic of a bag.

    Attributes
    ----------
    name : str
        Full topic name.
    message_type : str
        ROS type name.
    definition : str
        Message definition with all that it refers to.
    type_hash : str
        Hash of the type description, ``RIHS01_...``; "" where it is not known.
    offered_qos : str
        Profiles that publishers offered, a YAML list; "" where they are not known.
    definition_encoding : str
        ``ros2msg`` or ``ros2idl``.
    serialization_format : str
        How messages are serialized.
    """

    name: str
    message_type: str
    definition: str
    type_hash: str
    offered_qos: str
    definition_encoding: str = "ros2msg"
    serialization_format: str = "cdr"


class SerializedMessage(NamedTuple):
    """A message on its way into a bag: number of its topic, times [ns], serialized content."""

    topic: int
    received: int
    sent: int
    data: bytes


def topic_metadata(name: str, message_type: str, offered_qos: str) -> TopicMetadata:
    """Return a topic with the definition and the hash that ROS 2 Jazzy has for its type.

    Parameters
    ----------
    name : str
        Full topic name.
    message_type : str
        ROS type name, for example ``std_msgs/msg/String``.
    offered_qos : str
        See :class:`TopicMetadata`.

    Raises
    ------
    ValueError
        If Jazzy's common interfaces do not have the type.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    if message_type not in store.fielddefs:
        raise ValueError(
            f"topic {name} of type {message_type}: must be of a type of Jazzy's common interfaces"
        )
    definition, _ = store.generate_msgdef(message_type, ros_version=2)
    return TopicMetadata(
        name, message_type, definition, store.hash_rihs01(message_type), offered_qos
    )
