"""The ``ros2`` command: its output and exit codes have the shape of Jazzy's.

Nodes, parameters, services, interfaces, packages and the doctor; topics and bags have files of
their own.
"""

import re
import subprocess

import pytest
import yaml
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.node import Node
from ros2_commands import COMMAND, TIMEOUT_S, failure, ros2, ros2_all, ros2_processes
from ros2cli.cli import main
from ros2cli.commands.options import SPIN_TIME_S
from ros2cli.errors import CommandError, Terminated
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import SetBool


@pytest.fixture
def robot(ros, spin_in_thread):
    """Return a node that another thread spins while commands ask for it."""
    node = ros.create(Node, "robot")
    limits = FloatingPointRange(from_value=0.0, to_value=10.0)
    node.declare_parameter(
        "gain", 1.5, ParameterDescriptor(description="how much", floating_point_range=[limits])
    )
    node.declare_parameter("group.names", ["a", "b"])
    node.declare_parameter("size", 3, ParameterDescriptor(read_only=True))
    node.declare_parameter("size.unit", "m")
    node.create_publisher(Float64MultiArray, "data", 10)
    node.create_publisher(String, "_secret", 10)
    node.create_subscription(String, "words", lambda _: None, 10)

    def flip(request, response):
        response.success = not request.data
        return response

    node.create_service(SetBool, "flip", flip)

    spin_in_thread()
    return node


def test_nodes(robot):
    names, count, info, hidden, nobody = ros2_processes(
        ("node", "list", "--no-daemon"),
        ("node", "list", "-c"),
        ("node", "info", "/robot"),
        ("node", "info", "--include-hidden", "/robot"),
        ("node", "info", "/nobody"),
    )
    assert names == ("/robot\n", "", 0)
    assert count == ("1\n", "", 0)
    assert info[0].startswith(
        "/robot\n"
        "  Subscribers:\n"
        "    /words: std_msgs/msg/String\n"
        "  Publishers:\n"
        "    /data: std_msgs/msg/Float64MultiArray\n"
        "    /parameter_events: rcl_interfaces/msg/ParameterEvent\n"
        "    /rosout: rcl_interfaces/msg/Log\n"
        "  Service Servers:\n"
        "    /flip: std_srvs/srv/SetBool\n"
        "    /robot/describe_parameters: rcl_interfaces/srv/DescribeParameters\n"
    )
    assert info[0].endswith("  Service Clients:\n\n  Action Servers:\n\n  Action Clients:\n\n")
    assert "    /_secret: std_msgs/msg/String\n" in hidden[0]
    assert nobody == failure("Unable to find node '/nobody'")


def test_a_node_that_tells_its_name_late_is_waited_for(robot):
    graph = robot.context.handle.graph
    nodes = graph._own
    graph.leave()
    with subprocess.Popen([*COMMAND, "node", "list"], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert robot.wait_for_node(f"/_ros2cli_{process.pid}", TIMEOUT_S)
            # rmw_fastrtps tells a newcomer of its nodes up to 3 s after it is found.
            with pytest.raises(subprocess.TimeoutExpired):
                process.wait(SPIN_TIME_S + 1.0)
            graph._own = nodes
            graph._publish()
            assert process.communicate(timeout=TIMEOUT_S)[0] == "/robot\n"
        finally:
            process.kill()


def test_parameters_are_shown(robot):
    listed, typed, filtered, everything, gain, names, bare, described, missing, nobody = ros2_all(
        ("param", "list", "/robot"),
        ("param", "list", "--param-type", "/robot"),
        ("param", "list", "--filter", "g.*", "/robot"),
        ("param", "list"),
        ("param", "get", "/robot", "gain"),
        ("param", "get", "robot", "group.names"),
        ("param", "get", "--hide-type", "/robot", "gain"),
        ("param", "describe", "/robot", "gain", "size", "use_sim_time"),
        ("param", "get", "/robot", "nothing"),
        ("param", "get", "/nobody", "gain"),
    )
    lines = (
        "  gain\n  group.names\n  size\n  size.unit\n"
        "  start_type_description_service\n  use_sim_time\n"
    )
    assert listed == (lines, "", 0)
    assert everything == (f"/robot:\n{lines}", "", 0)
    assert "  group.names (type: string array)\n" in typed[0]
    assert "  use_sim_time (type: boolean)\n" in typed[0]
    assert filtered == ("  gain\n  group.names\n", "", 0)
    assert gain == ("Double value is: 1.5\n", "", 0)
    assert names == ("String values are: ['a', 'b']\n", "", 0)
    assert bare == ("1.5\n", "", 0)
    assert described[0] == (
        "Parameter name: gain\n  Type: double\n  Description: how much\n  Constraints:\n"
        "    Min value: 0.0\n    Max value: 10.0\n"
        "Parameter name: size\n  Type: integer\n  Constraints:\n    Read only: true\n"
        "Parameter name: use_sim_time\n  Type: boolean\n  Constraints:\n"
    )
    assert missing == failure("Parameter not set")
    assert nobody == failure("Node not found")


def test_what_is_misspelled_is_answered_with_what_is_there(robot):
    cases = {
        ("node", "info", "/robt"): "Unable to find node '/robt'; did you mean '/robot'?",
        ("param", "get", "/robt", "gain"): "Node not found; did you mean '/robot'?",
        ("param", "get", "/robot", "gian"): "Parameter not set; did you mean 'gain'?",
        ("param", "describe", "/robot", "gain", "zzz"): "Parameter not set: zzz",
        ("param", "list", "--filter", "(", "/robot"): "--filter '(' is no regular expression: ",
        ("service", "info", "/flop"): "Unknown service '/flop'; did you mean '/flip'?",
        ("service", "call", "/flip", "std_srvs/srv/SetBol"): (
            "Unknown service type 'std_srvs/srv/SetBol'; did you mean 'std_srvs/srv/SetBool'?"
        ),
        ("service", "call", "no name", "std_srvs/srv/Empty"): "Invalid service name: ",
        ("topic", "info", "/dota"): "Unknown topic '/dota'; did you mean '/data'?",
        ("run", "embedded_rose", "x"): (
            "Package 'embedded_rose' not found; did you mean 'embedded_ros'?"
        ),
        ("run", "embedded_ros", "ros"): "No executable found; did you mean 'ros2'?",
        ("run", "--prefix", "/no/gdb -x", "embedded_ros", "ros2"): "Could not start '/no/gdb': ",
        ("run", "--prefix", "'", "embedded_ros", "ros2"): "--prefix ",
    }
    results = ros2_all(*cases)
    for (words, complaint), (out, errors, code) in zip(cases.items(), results, strict=True):
        assert (out, errors.count("\n"), code) == ("", 1, 1), (words, errors)
        assert errors.startswith(complaint), words


def test_parameters_are_set(robot):
    # Jazzy reports a refused value, and succeeds.
    assert ros2("param", "set", "/robot", "gain", "99.0") == failure(
        "Setting parameter failed: Parameter gain out of range Min: 0.0, Max: 10.0, value: 99.0", 0
    )
    done, read_only, undeclared = ros2_all(
        ("param", "set", "/robot", "gain", "2.5"),
        ("param", "set", "/robot", "size", "4"),
        ("param", "delete", "/robot", "gain"),
    )
    assert done == ("Set parameter successful\n", "", 0)
    assert "Trying to set a read-only parameter: size." in read_only[1]
    assert undeclared[1].startswith("Deleting parameter failed: Static parameter cannot be")
    assert robot.get_parameter("gain").value == 2.5


def test_parameters_are_dumped_and_loaded(robot, tmp_path):
    path, other = tmp_path / "p.yaml", tmp_path / "q.yaml"
    no_names = tmp_path / "r.yaml"
    path.write_text("/robot: {ros__parameters: {gain: 7.5, size: 9}}")
    other.write_text("/robot: [")
    no_names.write_text("/robot: {ros__parameters: [1, 2]}")
    dumped, missing, malformed, nameless = ros2_all(
        ("param", "dump", "/robot"),
        ("param", "load", "/robot", "/nowhere.yaml"),
        ("param", "load", "/robot", str(other)),
        ("param", "load", "/robot", str(no_names)),
    )
    content = yaml.safe_load(dumped[0])["/robot"]["ros__parameters"]
    assert content["group"] == {"names": ["a", "b"]}
    # Below a value nothing can be nested; a file with a dotted name is read the same.
    assert (content["size"], content["size.unit"]) == (3, "m")
    assert missing == failure("[Errno 2] No such file or directory: '/nowhere.yaml'")
    assert malformed[1].startswith(f"{other} is not valid YAML: while parsing")
    assert malformed[1].count("\n") == malformed[2] == 1
    assert nameless[1].startswith(f"{no_names} is no parameter file: ")
    assert nameless[1].count("\n") == nameless[2] == 1
    assert ros2("param", "load", "/robot", str(path)) == (
        "Set parameter gain successful\n",
        "Set parameter size failed: Trying to set a read-only parameter: size.\n",
        0,
    )
    assert robot.get_parameter("gain").value == 7.5


def test_services(robot):
    listed, count, typed, unknown, found, info, no_info = ros2_all(
        ("service", "list", "-t"),
        ("service", "list", "-c"),
        ("service", "type", "/flip"),
        ("service", "type", "/nothing"),
        ("service", "find", "std_srvs/srv/SetBool"),
        ("service", "info", "/flip"),
        ("service", "info", "/nothing"),
    )
    assert "/flip [std_srvs/srv/SetBool]\n" in listed[0]
    assert "_ros2cli" not in listed[0]
    assert count[0] == f"{listed[0].count(chr(10))}\n"
    assert typed == ("std_srvs/srv/SetBool\n", "", 0)
    assert unknown == ("", "", 1)
    assert found == ("/flip\n", "", 0)
    assert info == ("Type: std_srvs/srv/SetBool\nClients count: 0\nServices count: 1\n", "", 0)
    assert no_info == failure("Unknown service '/nothing'")


def test_service_calls(robot):
    call = ("service", "call", "/flip")
    done, short, no_type, no_service, no_field, no_yaml = ros2_all(
        (*call, "std_srvs/srv/SetBool", "{data: true}"),
        (*call, "std_srvs/SetBool"),
        (*call, "std_srvs/srv/Nothing"),
        (*call, "std_msgs/msg/String"),
        (*call, "std_srvs/srv/SetBool", "{x: 1}"),
        (*call, "std_srvs/srv/SetBool", "{data: ["),
    )
    response = "response:\nstd_srvs.srv.SetBool_Response(success={}, message='')\n\n"
    assert done[0].endswith(
        "requester: making request: std_srvs.srv.SetBool_Request(data=True)\n\n"
        + response.format(False)
    )
    assert short[0].endswith(response.format(True))
    assert no_type == failure("Unknown service type 'std_srvs/srv/Nothing'")
    assert no_service == failure("'std_msgs/msg/String' is a message, not a service")
    assert no_field == failure("SetBool_Request has no field 'x', but data")
    assert no_yaml[1].startswith("'{data: [' is not valid YAML: ")
    assert no_yaml[1].count("\n") == no_yaml[2] == 1


def test_definitions_are_shown():
    pose, constants, default, service, unknown, no_package, malformed = ros2_all(
        ("interface", "show", "geometry_msgs/msg/PoseStamped"),
        ("interface", "show", "--no-comments", "diagnostic_msgs/msg/DiagnosticStatus"),
        ("interface", "show", "geometry_msgs/msg/Quaternion"),
        ("interface", "show", "rcl_interfaces/srv/ListParameters"),
        ("interface", "show", "std_msgs/msg/Nothing"),
        ("interface", "show", "nothing/msg/Nothing"),
        ("interface", "show", "std_msgs/String"),
    )
    assert pose[0].startswith(
        "std_msgs/Header header\n\tbuiltin_interfaces/Time stamp\n\t\tint32 sec\n"
        "\t\tuint32 nanosec\n\tstring frame_id\nPose pose\n\tPoint position\n\t\tfloat64 x\n"
    )
    assert "byte OK=0\n" in constants[0]
    assert "KeyValue[] values\n\tstring key\n" in constants[0]
    assert default[0].endswith("float64 w 1\n")
    assert service[0] == (
        "uint64 DEPTH_RECURSIVE=0\nstring[] prefixes\nuint64 depth\n---\n"
        "ListParametersResult result\n\tstring[] names\n\tstring[] prefixes\n"
    )
    assert unknown == failure("Unknown type 'std_msgs/msg/Nothing'")
    assert no_package == failure("Unknown type 'nothing/msg/Nothing'")
    assert malformed == failure(
        "'std_msgs/String' is no type such as std_msgs/msg/String; "
        "did you mean 'std_msgs/msg/String'?"
    )


def test_interfaces_are_listed():
    everything, services, packages, package, unknown = ros2_all(
        ("interface", "list"),
        ("interface", "list", "-s"),
        ("interface", "packages"),
        ("interface", "package", "std_srvs"),
        ("interface", "package", "nothing"),
    )
    assert everything[0].startswith("Messages:\n    actionlib_msgs/msg/GoalID\n")
    assert "Services:\n    diagnostic_msgs/srv/AddDiagnostics\n" in everything[0]
    assert everything[0].endswith("Actions:\n")
    assert "std_msgs" not in services[0]
    assert {"std_msgs", "std_srvs"} < set(packages[0].split())
    assert package[0] == "std_srvs/srv/Empty\nstd_srvs/srv/SetBool\nstd_srvs/srv/Trigger\n"
    assert unknown == failure("Unknown package 'nothing'")


def test_packages_and_executables():
    packages, executables, own, unknown, no_package, no_executable, nested = ros2_processes(
        ("pkg", "list"),
        ("pkg", "executables"),
        ("pkg", "executables", "embedded_ros"),
        ("pkg", "executables", "nothing"),
        ("run", "nothing", "at_all"),
        ("run", "embedded_ros", "nothing"),
        ("run", "embedded_ros", "ros2", "run", "nothing", "x"),
    )
    assert {"embedded_ros", "std_msgs"} < set(packages[0].split())
    # What pip has installed besides ROS packages is none.
    assert "pytest" not in executables[0]
    assert "embedded_ros ros2\n" in executables[0]
    assert own == ("embedded_ros ros2\n", "", 0)
    assert unknown == no_package == nested == failure("Package 'nothing' not found")
    assert no_executable == failure("No executable found")


def test_the_doctor_tells_what_runs_over_what(robot):
    checked, report = ros2_processes(("doctor",), ("doctor", "--report"))
    assert checked[0] == "\nAll 4 checks passed\n\n"
    assert "UserWarning: /data is published, and nobody subscribes.\n" in checked[1]
    assert checked[2] == report[2] == 0
    for line in (
        r"   RUNTIME\nruntime +: embedded_ros",
        r"middleware name +: rmw_cyclonedds_cpp\ntransport +: Cyclone DDS \d",
        r"discovery range +: LOCALHOST\n",
        r"interface +: lo \(this machine only\)\n",
        r"topic +: /data\npublisher count +: 1\nsubscriber count +: 0\n",
    ):
        assert re.search(line, report[0]), line


def test_a_domain_that_is_none_is_one_line(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    out, errors, code = ros2("topic", "list")
    assert (out, errors.count("\n"), code) == ("", 1, 1)
    assert "ROS_DOMAIN_ID is not an integral number" in errors


def test_commands_explain_themselves():
    top, group, verb, unknown, unknown_verb = ros2_all(
        (), ("topic",), ("bag", "play", "--help"), ("nothing",), ("topic", "nothing")
    )
    assert top[0].startswith("usage: ros2 [-h]")
    assert group[0].startswith("usage: ros2 topic [-h]")
    assert verb[0].startswith("usage: ros2 bag play [-h]")
    assert [result[2] for result in (top, group, verb)] == [0, 0, 0]
    for result in (unknown, unknown_verb):
        assert "invalid choice: 'nothing'" in result[1]
        assert result[2] == 2


@pytest.mark.parametrize(
    "words", [("interface", "list"), ("topic", "pub", "-r", "50", "/x", "std_msgs/msg/Empty")]
)
def test_a_reader_that_goes_away_is_no_error_text(words):
    with subprocess.Popen(
        [*COMMAND, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        process.stdout.close()
        try:
            assert process.stderr.read() == ""
            assert process.wait(TIMEOUT_S) == 1
        finally:
            process.kill()


@pytest.mark.parametrize(
    ("end", "code", "told"),
    [
        (KeyboardInterrupt(), 2, ""),
        (Terminated(), 15, ""),
        (CommandError("two\n  lines"), 1, "two lines\n"),
        (RuntimeError("rclpy\nrefuses"), 1, "rclpy refuses\n"),
    ],
)
def test_how_a_command_ends_is_its_exit_code(monkeypatch, capsys, end, code, told):
    def show_packages(_arguments):
        raise end

    monkeypatch.setattr("ros2cli.interfaces.show_packages", show_packages)
    assert main(["interface", "packages"]) == code
    assert capsys.readouterr() == ("", told)


def test_what_is_no_users_mistake_is_not_hidden(monkeypatch):
    monkeypatch.setattr("ros2cli.interfaces.show_packages", lambda _arguments: {}["bug"])
    with pytest.raises(KeyError):
        main(["interface", "packages"])
