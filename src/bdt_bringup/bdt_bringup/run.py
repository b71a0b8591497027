"""Runs the loop: starts the nodes, watches them, stops everything, in one or many processes."""

from typing import Any

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from bdt_bringup.installed import node_class
from bdt_bringup.loop_state import MACHINES
from bdt_bringup.monitor import MonitorNode
from bdt_bringup.participant import participant
from bdt_bringup.progress_display import ProgressDisplay
from bdt_bringup.real_machine import RealMachine
from bdt_bringup.run_plan import RunPlan
from bdt_bringup.supervisor import Supervisor, raise_for_ended_node
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.folder_sync import create_folder
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_msgs_py.output_files import not_writable
from bdt_msgs_py.spinning import drain_messages
from bdt_msgs_py.stop_signals import StopSignals
from bdt_msgs_py.topics import PLANT_NODE, RECORDER_NODE

REFRESH = 0.1
"""Wall time [s] between two looks at the nodes and two updates of the progress bar."""


def run_loop(plan: RunPlan) -> float | None:
    """Run the loop to its end.

    Parameters
    ----------
    plan : RunPlan
        What to start.

    Returns
    -------
    float or None
        Simulated seconds per second of wall time; None of a run so short that nobody saw it.

    Raises
    ------
    BadInputError
        If another loop runs in the same namespace of the same ROS domain, or a node refuses its
        parameters.
    LoopError
        If a node ended before its time, and too often if it is supervised; the text says which one
        and what it said last.
    KeyboardInterrupt
        After Ctrl-C or SIGTERM, when all nodes have been stopped.
    """
    try:
        create_folder(plan.output)
    except OSError as error:
        raise not_writable("--output", plan.output, error) from error
    with (
        participant(MonitorNode, plan.configuration.namespace) as (monitor, executor),
        StopSignals() as signals,
    ):
        _refuse_second_loop(executor, monitor)
        with ProgressDisplay(plan.configuration.name, plan.duration) as display:
            if plan.processes == "single":
                _run_in_this_process(plan, executor, monitor, display, signals)
            else:
                _run_in_processes(plan, executor, monitor, display, signals)
        return monitor.real_time_factor()


def _refuse_second_loop(executor: SingleThreadedExecutor, monitor: MonitorNode) -> None:
    # Discovery of what already runs on this machine takes a few hundredths of a second.
    executor.spin_until_future_complete(Future(), timeout_sec=3 * REFRESH)
    namespace = monitor.get_namespace()
    running = monitor.get_node_names_and_namespaces()
    for machine in MACHINES:
        if (machine, namespace) in running:
            raise BadInputError(
                f"{namespace.rstrip('/')}/{machine} already runs in this ROS domain: stop it, or "
                "choose another --namespace or ROS_DOMAIN_ID"
            )


def _run_in_processes(
    plan: RunPlan,
    executor: SingleThreadedExecutor,
    monitor: MonitorNode,
    display: ProgressDisplay,
    signals: StopSignals,
) -> None:
    supervisor = Supervisor(plan)
    try:
        supervisor.start_all()
        if plan.is_real:
            _follow_real_machine(plan, supervisor, executor, monitor, display, signals)
        else:
            _follow_plant(supervisor, executor, monitor, display, signals)
    finally:
        supervisor.stop()
    supervisor.raise_for_failures()


def _follow_plant(
    supervisor: Supervisor,
    executor: SingleThreadedExecutor,
    monitor: MonitorNode,
    display: ProgressDisplay,
    signals: StopSignals,
) -> None:
    """Return when the plant has ended."""
    while supervisor.machine.exit_code is None:
        executor.spin_once(timeout_sec=REFRESH)
        display.show(monitor)
        signals.check()
        supervisor.look()
    if supervisor.machine.exit_code != 0:
        supervisor.raise_for_failures()


def _follow_real_machine(
    plan: RunPlan,
    supervisor: Supervisor,
    executor: SingleThreadedExecutor,
    monitor: MonitorNode,
    display: ProgressDisplay,
    signals: StopSignals,
) -> None:
    """Return when the machine was armed for the duration of the run, and is disarmed."""
    machine = RealMachine(monitor, plan.nodes)
    while machine.simulated_time < plan.duration:
        executor.spin_once(timeout_sec=REFRESH)
        machine.look()
        display.show(machine)
        signals.check()
        supervisor.look()
        if supervisor.machine.exit_code is not None:
            raise_for_ended_node([supervisor.machine])
    machine.disarm(executor)


def _run_in_this_process(
    plan: RunPlan,
    executor: SingleThreadedExecutor,
    monitor: MonitorNode,
    display: ProgressDisplay,
    signals: StopSignals,
) -> None:
    nodes: dict[str, Any] = {}
    try:
        for name in plan.nodes:
            nodes[name] = _create_node(plan, name, monitor.context)
            executor.add_node(nodes[name])
        finished = nodes[PLANT_NODE].finished
        while not finished.done():
            executor.spin_until_future_complete(finished, timeout_sec=REFRESH)
            display.show(monitor)
            signals.check()
        finished.result()
    finally:
        recorder = nodes.pop(RECORDER_NODE, None)
        for node in nodes.values():
            executor.remove_node(node)
            node.destroy_node()
        if recorder is not None:
            # What the others said last is still in its queues.
            drain_messages(executor, recorder)
            executor.remove_node(recorder)
            try:
                recorder.close_bag()
            finally:
                recorder.destroy_node()


def _create_node(plan: RunPlan, name: str, context: Context) -> Node:
    arguments = ["--ros-args", *plan.ros_arguments(name)]
    try:
        node: Node = node_class(name)(context=context, cli_args=arguments)
    except ConfigurationError as error:
        raise BadInputError(f"node {name}: {error}") from error
    return node
