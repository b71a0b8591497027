"""Services that get and set the levels of loggers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import rclpy.logging

if TYPE_CHECKING:
    from rclpy.node import Node

__all__ = ["LoggingService"]


class LoggingService:
    """The services ``get_logger_levels`` and ``set_logger_levels`` of a node."""

    def __init__(self, node: Node) -> None:
        from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels

        name = node.get_name()
        node.create_service(GetLoggerLevels, f"{name}/get_logger_levels", self._get_logger_levels)
        node.create_service(SetLoggerLevels, f"{name}/set_logger_levels", self._set_logger_levels)

    def _get_logger_levels(self, request: Any, response: Any) -> Any:
        from rcl_interfaces.msg import LoggerLevel

        response.levels = [
            LoggerLevel(name=name, level=int(rclpy.logging.get_logger_level(name)))
            for name in request.names
        ]
        return response

    def _set_logger_levels(self, request: Any, response: Any) -> Any:
        from rcl_interfaces.msg import SetLoggerLevelsResult

        for level in request.levels:
            result = SetLoggerLevelsResult(successful=True)
            try:
                rclpy.logging.set_logger_level(level.name, level.level, detailed_error=True)
            except ValueError:
                result = SetLoggerLevelsResult(
                    successful=False, reason="Failed reason: Invalid logger level."
                )
            response.results.append(result)
        return response
