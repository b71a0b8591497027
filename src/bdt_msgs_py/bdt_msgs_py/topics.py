"""Every topic of the project: name, type, quality of service and content.

Pure data, so that tools that read bags need no rclpy. The names are relative: a namespace or a
remap rule moves all of them. :mod:`bdt_msgs_py.qos` turns a :class:`Topic` into a QoSProfile.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Topic:
    """A topic of the public interface.

    Attributes
    ----------
    name : str
        Relative topic name (absolute for the names that ROS fixes).
    message_type : str
        ROS type name, for example ``sensor_msgs/msg/JointState``.
    content : str
        What a message says, with units.
    reliable : bool
        Reliable or best-effort delivery.
    transient_local : bool
        True when a late subscriber receives the last message.
    depth : int
        Length of the history.
    kept : int
        Messages that a publisher keeps for reliable subscribers that do not answer for a while,
        a recorder on a busy machine for example; a subscriber's own history is `depth`. Half a
        megabyte that nobody has confirmed makes Cyclone DDS hold the publisher back.
    """

    name: str
    message_type: str
    content: str
    reliable: bool = True
    transient_local: bool = False
    depth: int = 10
    kept: int = 0


JOINT_STATE = "sensor_msgs/msg/JointState"
SAMPLES = "std_msgs/msg/Float64MultiArray"

MEASUREMENT = Topic(
    "measurement",
    JOINT_STATE,
    "joint platform_3, position q3 [m] as measured; stamp = sample time",
    kept=1000,
)
COMMAND = Topic(
    "command",
    JOINT_STATE,
    "joint motor, effort = motor voltage u [V], the effort variable of the electrical domain; "
    "stamp = stamp of the measurement it answers; frame_id = who sends it: the plant obeys one "
    "source at a time",
    kept=1000,
)
REFERENCE = Topic(
    "reference",
    JOINT_STATE,
    "joint platform_3, position r [m]; stamp = time from which it holds",
    transient_local=True,
    depth=1,
)
TELEMETRY = Topic(
    "telemetry",
    SAMPLES,
    "rows of (t [s], u [V] as applied, q3 [m] as measured) at the sampling rate, oldest first; "
    "layout.dim[0].size = rows, layout.dim[1].size = 3 with the label t[s],u[V],q3[m]; t on the "
    "clock of the stamps of measurement, evenly spaced but for that clock's jitter, also from one "
    "message to the next",
    depth=100,
)
TRUTH = Topic(
    "truth",
    SAMPLES,
    "rows of (t [s], theta_m [rad], theta_d [rad], gap [rad], q1 [m], q2 [m], q3 [m]) at the "
    "control rate; known to a simulator only, read by neither controller nor twin",
    reliable=False,
)
BACKLASH_ESTIMATE = Topic(
    "backlash_estimate",
    JOINT_STATE,
    "joint backlash_gap: position = estimate [rad], velocity = its growth rate [rad/s]; joint "
    "backlash_gap_standard_uncertainty: position [rad]; joint backlash_gap_age: position = time "
    "from the stamp to the newest sample behind the estimate [s]; joint dead_zone_tolerance: "
    "position = dead zone that the twin asks for [m], left out when it only estimates; joint "
    "voltage_offset: effort = voltage that the controller is asked to add to its commands [V], "
    "left out when it is not; stamp = time for which the gap is stated",
    transient_local=True,
    depth=1,
)
PROGRESS = Topic(
    "progress",
    "sensor_msgs/msg/TimeReference",
    "source = node that keeps step with a lockstep plant, stamp = newest telemetry sample it has "
    "worked on, time_ref = simulated time before which it will not act on the loop, whatever "
    "telemetry comes",
    depth=100,
)
PROGRESS_PERIOD = 0.1
"""Wall time [s] after which progress is told again: a lost message delays lockstep by it."""
MARK = Topic(
    "mark",
    "std_msgs/msg/Header",
    "a moment that somebody wants to find again: stamp = which one, on the clock of telemetry; "
    "frame_id = who has marked it",
)
CLOCK = Topic("/clock", "rosgraph_msgs/msg/Clock", "simulated time", reliable=False, depth=1)
DIAGNOSTICS = Topic(
    "/diagnostics",
    "diagnostic_msgs/msg/DiagnosticArray",
    "health of each node, once a second of wall time",
)
PARAMETER_EVENTS = Topic(
    "/parameter_events",
    "rcl_interfaces/msg/ParameterEvent",
    "every parameter that changed; a reconfiguration of the dead zone is one of them",
    depth=1000,
)

ALL_TOPICS = (
    MEASUREMENT,
    COMMAND,
    REFERENCE,
    TELEMETRY,
    TRUTH,
    BACKLASH_ESTIMATE,
    PROGRESS,
    MARK,
    CLOCK,
    DIAGNOSTICS,
    PARAMETER_EVENTS,
)
"""The public interface; ROS's own topics that the project uses are the last three."""

PLATFORM_JOINT = "platform_3"
MOTOR_JOINT = "motor"
GAP_JOINT = "backlash_gap"
GAP_UNCERTAINTY_JOINT = "backlash_gap_standard_uncertainty"
GAP_AGE_JOINT = "backlash_gap_age"
DEAD_ZONE_JOINT = "dead_zone_tolerance"
VOLTAGE_OFFSET_JOINT = "voltage_offset"

TELEMETRY_COLUMNS = ("t[s]", "u[V]", "q3[m]")
TRUTH_COLUMNS = (
    "t[s]",
    "theta_m[rad]",
    "theta_d[rad]",
    "gap[rad]",
    "q1[m]",
    "q2[m]",
    "q3[m]",
)

PLANT_NODE = "plant"
DRIVER_NODE = "driver"
CONTROLLER_NODE = "controller"
TWIN_NODE = "twin"
RECORDER_NODE = "recorder"
DEAD_ZONE_PARAMETER = "dead_zone_tolerance"
VOLTAGE_OFFSET_PARAMETER = "voltage_offset"
