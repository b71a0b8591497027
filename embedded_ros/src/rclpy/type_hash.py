"""Hashes of type definitions."""

from embedded_ros.endpoint_info import TypeHash
from embedded_ros.public_names import shown_in

__all__ = ["TypeHash"]

shown_in(__name__, TypeHash)
