"""What can be typed after ``ros2``: tables of arguments, without what they lead to."""

import subprocess
import sys
from pkgutil import resolve_name

import pytest
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPresetProfiles,
    ReliabilityPolicy,
)
from ros2cli.commands import COMMANDS
from ros2cli.commands.options import quality_of_service
from ros2cli.grammar import Command, build_parser

VERBS = [
    (words, verb)
    for item in COMMANDS
    for words, verb in (
        [((item.name, verb.name), verb) for verb in item.verbs]
        if isinstance(item, Command)
        else [((item.name,), item)]
    )
]


def parse(*words):
    return build_parser("ros2", "", COMMANDS).parse_args(words)


@pytest.mark.parametrize(("words", "verb"), VERBS, ids=[" ".join(words) for words, _ in VERBS])
def test_each_verb_explains_itself_and_leads_somewhere(words, verb, capsys):
    with pytest.raises(SystemExit) as end:
        parse(*words, "--help")
    assert end.value.code == 0
    out = capsys.readouterr().out
    assert out.startswith(f"usage: ros2 {' '.join(words)} [-h]")
    assert verb.summary.split()[0] in out
    assert callable(resolve_name(f"ros2cli.{verb.call}"))


def test_help_waits_for_nothing_that_it_does_not_need():
    code = (
        "import sys; from ros2cli.cli import main\n"
        "assert main(['topic', 'echo', '--help']) == 0\n"
        "heavy = {'rclpy', 'embedded_ros', 'cyclonedds', 'numpy', 'yaml', 'rosbags'}\n"
        "sys.exit(str(heavy & set(sys.modules)) if heavy & set(sys.modules) else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_options_know_the_qos_of_rclpy():
    keys = {
        argument.names[0]: dict(argument.settings).get("choices")
        for argument in quality_of_service("default")
    }
    assert keys["--qos-profile"] == QoSPresetProfiles.short_keys()
    for policy in (HistoryPolicy, ReliabilityPolicy, DurabilityPolicy, LivelinessPolicy):
        name = policy.__name__.removesuffix("Policy").lower()
        assert keys[f"--qos-{name}"] == policy.short_keys()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("topic", "hz", "/x", "-w", "0"), "-w/--window: must be above 0, not '0'"),
        (("topic", "hz", "/x", "-w", "1.5"), "-w/--window: must be an integer, not '1.5'"),
        (("topic", "echo", "/x", "-l", "-1"), "must be at least 0, not '-1'"),
        (("topic", "echo", "/x", "--timeout", "nan"), "must be a number, not 'nan'"),
        (("topic", "list", "--spin-time", "inf"), "must be a number, not 'inf'"),
        (("topic", "pub", "/x", "T", "-r", "0"), "-r/--rate: must be above 0, not '0'"),
        (("topic", "pub", "/x", "T", "-r", "1e300"), "must be at most 1000000000, not '1e300'"),
        (("topic", "pub", "/x", "T", "-1", "-t", "3"), "not allowed with argument -1/--once"),
        (("param", "set", "/x", "gain"), "the following arguments are required: value"),
        (("topic", "ecko"), "invalid choice: 'ecko' (choose from "),
    ],
)
def test_what_cannot_be_typed_is_one_line_and_code_2(words, complaint, capsys):
    with pytest.raises(SystemExit) as end:
        parse(*words)
    errors = capsys.readouterr().err
    assert end.value.code == 2
    assert complaint in errors
    assert errors.count("\n") == 1
    assert errors.startswith("ros2 ")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("bag", "play", "."), {"rate": 1.0, "clock": None, "playback_duration": -1.0}),
        (("bag", "play", ".", "--clock"), {"clock": 40.0}),
        (("bag", "play", ".", "--playback-duration", "-1"), {"playback_duration": -1.0}),
        (("bag", "record", "/a", "/b"), {"topics_positional": ["/a", "/b"], "all": False}),
        (("interface", "list", "-m", "-s"), {"kinds": ["msg", "srv"]}),
        (("run", "p", "x", "--ros-args", "-p", "a:=1"), {"argv": ["--ros-args", "-p", "a:=1"]}),
        (("topic", "pub", "/x", "T"), {"values": "{}", "rate": 1.0, "times": 0, "print": 1}),
        (("topic", "echo", "/x"), {"message_type": None, "truncate_length": 128, "once": False}),
    ],
)
def test_arguments_have_the_defaults_of_jazzy(words, expected):
    arguments = vars(parse(*words))
    assert {name: arguments[name] for name in expected} == expected
