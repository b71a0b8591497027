"""``ros2 service call``: a request and its response."""

import argparse
from typing import Any

import rclpy
from ros2cli.messages import import_type, message_of, parse_values
from ros2cli.node_session import command_node, listen, wait_until

__all__ = ["call"]


def call(arguments: argparse.Namespace) -> None:
    """``service call``."""
    service = import_type(arguments.service_type, "srv")
    request, _ = message_of(service.Request, parse_values(arguments.values))
    with command_node() as node:
        client = node.create_client(service, arguments.service_name)
        if not client.service_is_ready():
            print("waiting for service to become available...", flush=True)
        while wait_until(node, client.service_is_ready):
            print(f"requester: making request: {request!r}\n", flush=True)
            response = _response(node, client.call_async(request))
            print(f"response:\n{response!r}\n", flush=True)
            if arguments.rate is None:
                return
            listen(node, 1.0 / arguments.rate)


def _response(node: Any, future: Any) -> Any:
    rclpy.spin_until_future_complete(node, future)
    return future.result()
