"""Layouts for other tools in config/: every topic and field in them is one of this project's."""

import json
import re
import xml.etree.ElementTree as ET
from ast import literal_eval
from pathlib import Path
from typing import Any

import pytest
from rosbags.typesys import Stores, get_typestore

from bdt_msgs_py.topics import (
    ALL_TOPICS,
    BACKLASH_ESTIMATE,
    COMMAND,
    DEAD_ZONE_PARAMETER,
    GAP_JOINT,
    JOINT_STATE,
    MOTOR_JOINT,
    PARAMETER_EVENTS,
    PLATFORM_JOINT,
    REFERENCE,
    TRUTH,
    TRUTH_COLUMNS,
    Topic,
)

CONFIG = Path(__file__).parents[1] / "config"
STORE = get_typestore(Stores.ROS2_JAZZY)
TOPICS = {f"/{topic.name.removeprefix('/')}": topic for topic in ALL_TOPICS}
NUMBERS = {"float64", "float32", "int64", "int32"}

# Kinds of fields in the definitions of rosbags.
BASE, NAME, ARRAY, SEQUENCE = 1, 2, 3, 4


def field_type(message_type: str, parts: list[str]) -> str:
    """Return the type at the end of a path of fields; a part may carry an index in brackets."""
    if not parts:
        return message_type
    name, bracket, _ = parts[0].partition("[")
    kind, detail = dict(STORE.get_msgdef(message_type).fields)[name]
    assert bool(bracket) == (kind in {ARRAY, SEQUENCE}), f"{parts[0]} in {message_type}"
    if kind in {ARRAY, SEQUENCE}:
        kind, detail = detail[0]
    if kind == NAME:
        return field_type(detail, parts[1:])
    assert len(parts) == 1
    return detail[0]


def plotjuggler_layout() -> ET.Element:
    return ET.parse(CONFIG / "plotjuggler_layout.xml").getroot()  # noqa: S314 - our own file


def plotjuggler_curves() -> list[str]:
    return [curve.attrib["name"] for curve in plotjuggler_layout().iter("curve")]


def foxglove_layout() -> dict[str, Any]:
    layout: dict[str, Any] = json.loads((CONFIG / "foxglove_layout.json").read_text())
    return layout


def foxglove_series() -> list[dict[str, Any]]:
    panels = foxglove_layout()["configById"].values()
    return [path for panel in panels for path in panel.get("paths", [])]


def foxglove_paths() -> list[str]:
    return [path["value"] for path in foxglove_series()]


def rqt_plots() -> list[dict[str, Any]]:
    """Return the settings of each plot in the perspective, which rqt keeps as their `repr`."""
    perspective = json.loads((CONFIG / "rqt_plot.perspective").read_text())
    manager = perspective["groups"]["pluginmanager"]
    running = literal_eval(manager["keys"]["running-plugins"]["repr"])["rqt_plot/Plot"]
    plugins = [manager["groups"][f"plugin__rqt_plot__Plot__{number}"] for number in running]
    return [
        {
            key: literal_eval(value["repr"])
            for key, value in plugin["groups"]["plugin"]["keys"].items()
        }
        for plugin in plugins
    ]


def rqt_plot_topics() -> list[str]:
    return [plot["topics"] for plot in rqt_plots()]


def of_joint_state(topic: Topic, field: str) -> None:
    assert field == ("effort" if topic is COMMAND else "position")


@pytest.mark.parametrize("curve", plotjuggler_curves())
def test_plotjuggler_names_topics_joints_and_fields(curve):
    topic = TOPICS["/" + curve.split("/")[1]]
    rest = curve.split("/")[2:]
    if topic.message_type == JOINT_STATE:  # PlotJuggler names such a curve by its joint
        joint, field = rest
        assert joint == {
            "command": MOTOR_JOINT,
            "backlash_estimate": GAP_JOINT,
        }.get(topic.name, PLATFORM_JOINT)
        of_joint_state(topic, field)
    else:
        assert field_type(topic.message_type, rest) in NUMBERS


@pytest.mark.parametrize("path", foxglove_paths())
def test_foxglove_names_topics_and_fields(path):
    condition = re.search(r'\{name=="(.*?)"\}', path)
    assert condition is None or condition[1] == DEAD_ZONE_PARAMETER
    name, *parts = re.sub(r"\{.*?\}", "", path).split(".")
    topic = TOPICS[name]
    assert field_type(topic.message_type, parts) in NUMBERS
    if topic.message_type == JOINT_STATE:
        of_joint_state(topic, parts[0].partition("[")[0])


@pytest.mark.parametrize("name", rqt_plot_topics())
def test_rqt_plot_names_topics_and_fields(name):
    _, name, *parts = name.split("/")
    topic = TOPICS[f"/{name}"]
    assert topic.message_type == JOINT_STATE, "what has no stamp is at another place of its axis"
    assert field_type(topic.message_type, parts) in NUMBERS
    of_joint_state(topic, parts[0].partition("[")[0])


def test_rqt_plot_starts_from_limits_narrower_than_the_data():
    heights = {}
    for plot in rqt_plots():
        low, high = map(float, plot["y_limits"])
        heights[plot["topics"].split("/")[1]] = high - low
    assert 0 < heights["measurement"] < 0.02, "it widens limits, and narrows none: steps are 5 mm"
    assert 0 < heights["backlash_estimate"] < 0.02, "the gap begins at 0 rad"
    assert 0 < heights["command"] < 10


def test_every_tool_shows_position_voltage_and_estimate():
    for names in (plotjuggler_curves(), foxglove_paths(), rqt_plot_topics()):
        shown = {re.split(r"[/.]", name.removeprefix("/"))[0] for name in names}
        assert {"measurement", "command", "backlash_estimate"} <= shown


@pytest.mark.parametrize("topic", [REFERENCE, BACKLASH_ESTIMATE, PARAMETER_EVENTS])
def test_no_tool_joins_messages_that_hold_until_the_next_one_by_a_ramp(topic):
    name = topic.name.removeprefix("/")
    (plot,) = (
        plot
        for plot in plotjuggler_layout().iter("plot")
        if any(curve.attrib["name"].startswith(f"/{name}/") for curve in plot.iter("curve"))
    )
    assert plot.attrib["style"] == "StepsInv", "its Steps show a message from the one before on"
    (series,) = (series for series in foxglove_series() if series["value"].startswith(f"/{name}."))
    assert series["showLine"] is False


def test_rqt_plot_which_has_lines_only_leaves_the_steps_of_the_reference_out():
    assert not any(name.startswith(f"/{REFERENCE.name}/") for name in rqt_plot_topics())


def test_the_element_of_the_truth_is_the_gap():
    index = TRUTH_COLUMNS.index("gap[rad]")
    assert f"/{TRUTH.name}/data[{index}]" in plotjuggler_curves()
    assert f"/{TRUTH.name}.data[{index}]" in foxglove_paths()


def test_foxglove_shows_every_panel_once():
    def leaves(node: Any) -> list[str]:
        return [node] if isinstance(node, str) else leaves(node["first"]) + leaves(node["second"])

    layout = foxglove_layout()
    assert sorted(leaves(layout["layout"])) == sorted(layout["configById"])


@pytest.mark.parametrize("panel", foxglove_layout()["configById"])
def test_foxglove_and_its_open_fork_find_each_title(panel):
    config = foxglove_layout()["configById"][panel]
    assert config["foxglovePanelTitle"]
    assert config["lichtblickPanelTitle"] == config["foxglovePanelTitle"]


def test_plotjuggler_has_as_many_plots_as_it_says():
    (splitter,) = plotjuggler_layout().iter("DockSplitter")
    count = int(splitter.attrib["count"])
    assert len(list(splitter)) == len(splitter.attrib["sizes"].split(";")) == count
