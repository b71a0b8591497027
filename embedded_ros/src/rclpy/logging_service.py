"""Services that get and set the levels of loggers."""

from __future__ import annotations

from typing import Any

import rclpy.logging
from embedded_ros.message_classes import message_class
from embedded_ros.serving import ServingNode

__all__ = ["LoggingService"]


class LoggingService:
    """The services ``get_logger_levels`` and ``set_logger_levels`` of a node.

    They reach all loggers of the process, whatever node they belong to.
    """

    def __init__(self, node: ServingNode) -> None:
        from rcl_interfaces import srv

        for name, service, answer in (
            ("get_logger_levels", srv.GetLoggerLevels, _get_levels),
            ("set_logger_levels", srv.SetLoggerLevels, _set_levels),
        ):
            node.create_service(service, f"{node.get_name()}/{name}", answer)


def _get_levels(request: Any, response: Any) -> Any:
    level = message_class("rcl_interfaces/msg/LoggerLevel")
    for name in request.names:
        response.levels.append(level(name=name, level=rclpy.logging.get_logger_level(name).value))
    return response


def _set_levels(request: Any, response: Any) -> Any:
    response.results = [_set_level(wish.name, wish.level) for wish in request.levels]
    return response


def _set_level(name: str, level: int) -> Any:
    result = message_class("rcl_interfaces/msg/SetLoggerLevelsResult")
    if level not in tuple(rclpy.logging.LoggingSeverity):
        return result(successful=False, reason="Failed reason: Invalid logger level.")
    rclpy.logging.set_logger_level(name, level)
    return result(successful=True)
