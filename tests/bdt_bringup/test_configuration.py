"""Parameter files are checked as a whole before anything starts."""

import math
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from shipped_configurations import SHIPPED

from bdt_bringup.configuration import CONFIGURED_NODES, load_configuration
from bdt_bringup.installed import parameter_table
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.configuration_files import find_configuration, packaged_configurations
from bdt_msgs_py.parameter_files import unused_files
from bdt_msgs_py.parameter_tables import known_parameters
from bdt_plant.actuator import ActuatorParameters
from bdt_plant.sensor import SensorParameters
from bdt_study.design.tuned_gains import TUNED_GAINS
from bdt_study.evaluation.trial import MARGIN

CONFIG = Path(__file__).parents[2] / "config"


def written(folder, text):
    path = folder / "file.yaml"
    path.write_text(text)
    return path


def parameters(node, text):
    return f"{node}:\n  ros__parameters:\n    {text}\n"


@pytest.mark.parametrize("name", SHIPPED)
def test_the_shipped_configurations_are_valid(name):
    configuration = load_configuration(CONFIG / f"{name}.yaml")
    assert configuration.name == name
    if configuration.machine == "plant":
        assert configuration.value("plant", "duration") == 120.0


def test_the_configurations_differ_in_the_dead_zone_and_in_reconfiguration_alone():
    paper, linear, fixed = (
        load_configuration(CONFIG / f"{name}.yaml")
        for name in ("paper", "linear", "fixed_dead_zone")
    )
    assert paper.values["plant"] == linear.values["plant"] == fixed.values["plant"]
    assert paper.value("twin", "reconfigure") is True
    assert linear.value("twin", "reconfigure") is fixed.value("twin", "reconfigure") is False
    assert linear.value("controller", "dead_zone_tolerance") == 0.0
    # 10 degrees of a screw with 1 mm travel per turn.
    assert fixed.value("controller", "dead_zone_tolerance") == pytest.approx(1e-3 * 10 / 360)


def differences(name, other):
    """Return the values of a shipped configuration that are not those of another one."""
    ours, theirs = (load_configuration(CONFIG / f"{each}.yaml") for each in (name, other))
    return {
        (node, parameter): ours.value(node, parameter)
        for node in CONFIGURED_NODES
        for parameter in known_parameters(parameter_table(node))
        if ours.value(node, parameter) != theirs.value(node, parameter)
    }


def test_the_simulated_one_is_the_laboratory_with_a_twin_that_decides_by_simulating():
    differs = differences("simulated", "laboratory")
    gains = vars(TUNED_GAINS.pid)
    assert differs == {
        ("twin", "decision.kind"): "simulate",
        ("twin", "decision.reconfigure_gains"): True,
        ("twin", "decision.voltage_limit"): 24.0,
        **{("twin", f"redesign.{name}"): value for name, value in gains.items()},
    }


def test_the_workshop_is_the_simulated_laboratory_with_an_everyday_machine():
    differs = differences("workshop", "simulated")
    assert {node for node, _ in differs} == {"plant"}
    assert {name: value for (_, name), value in differs.items()} == {
        "sensor.delay": 2e-4,
        "sensor.drift": pytest.approx(5e-6 / 120.0, rel=1e-3),
        "sensor.periodic_error": 2e-7,
        "sensor.periodic_length": 2e-5,
        "actuator.offset": 0.02,
        "actuator.resolution": 48.0 / 2**12,
        "motor.back_emf_constant": pytest.approx(1.04 * 0.1),
        "motor.resistance": pytest.approx(1.08 * 12.0),
        "motor.coulomb_friction": 8e-3,
        "motor.static_friction": 1e-2,
        "motor.viscous_friction": 1e-5,
        "motor.cogging_torque": 1e-3,
        "lead_screw.efficiency": 0.4,
        "structure.damping": pytest.approx(1.1 * 36.9),
    }


def test_the_laboratory_is_the_paper_s_scenario_with_imperfect_hardware():
    assert differences("laboratory", "paper") == {
        ("plant", "sensor.noise"): 1e-6,
        ("plant", "sensor.quantization"): 1e-7,
        ("plant", "actuator.saturation"): True,
        ("plant", "actuator.voltage_limit"): 24.0,
        ("plant", "motor.back_emf_constant"): pytest.approx(1.05 * 0.1),
        ("plant", "structure.mass"): pytest.approx(1.02 * 5.2),
        ("plant", "structure.stiffness"): pytest.approx(0.98 * 1e4),
        ("controller", "voltage_limit"): 24.0,
        ("twin", "estimator.kind"): "output_error",
        ("twin", "dead_zone.coverage_factor"): MARGIN.coverage_factor,
        ("twin", "dead_zone.margin"): pytest.approx(MARGIN.margin, rel=1e-5),
        ("twin", "dead_zone.horizon"): MARGIN.horizon,
    }


@pytest.mark.parametrize("name", ["paper", "linear", "fixed_dead_zone"])
def test_the_paper_s_hardware_is_perfect(name):
    configuration = load_configuration(CONFIG / f"{name}.yaml")
    for node in CONFIGURED_NODES:
        for parameter in known_parameters(parameter_table(node)):
            if parameter.startswith(("sensor.", "actuator.", "motor.", "structure.")):
                assert parameter not in configuration.values[node]
    assert SensorParameters().is_ideal
    assert ActuatorParameters().limit == math.inf


def test_without_a_file_everything_has_its_default():
    configuration = load_configuration(None)
    for node in CONFIGURED_NODES:
        for name, (default, _) in known_parameters(parameter_table(node)).items():
            assert configuration.value(node, name) == default


def test_nested_and_dotted_names_wildcards_and_namespaces_are_the_same_parameters(tmp_path):
    dotted = load_configuration(written(tmp_path, parameters("/**/plant", "gap.final: 0.1")))
    assert dotted.value("plant", "gap.final") == 0.1
    path = written(tmp_path, parameters("/cell/plant", "gap: {final: 0.1}"))
    nested = load_configuration(path, "/cell")
    assert nested.value("plant", "gap.final") == 0.1
    wild = load_configuration(written(tmp_path, parameters("/**", "motor.inertia: 1.0e-5")))
    assert wild.value("plant", "motor.inertia") == wild.value("twin", "motor.inertia") == 1e-5


@pytest.mark.parametrize("namespace", ["", "/left", "/laboratory/left"])
@pytest.mark.parametrize("name", SHIPPED)
def test_the_shipped_configurations_are_for_the_nodes_in_any_namespace(name, namespace):
    path = CONFIG / f"{name}.yaml"
    configuration = load_configuration(path, namespace)
    assert configuration.configured == {configuration.machine, "controller", "twin"}
    assert configuration.values == load_configuration(path).values
    for node in configuration.configured:
        assert unused_files(["--ros-args", "--params-file", str(path)], f"{namespace}/{node}") == []


def test_a_file_for_several_namespaces_configures_the_nodes_of_one(tmp_path):
    text = parameters("/left/plant", "duration: 1.0") + parameters("/right/plant", "duration: 2.0")
    path = written(tmp_path, text)
    assert load_configuration(path, "/left").value("plant", "duration") == 1.0
    assert load_configuration(path, "/right").value("plant", "duration") == 2.0
    assert load_configuration(path, "/right").configured == {"plant"}


@pytest.mark.parametrize(
    ("section", "namespace"), [("plant", "/left"), ("/left/plant", ""), ("/right/plant", "/left")]
)
def test_a_section_for_the_node_in_another_namespace_is_refused(tmp_path, section, namespace):
    path = written(tmp_path, parameters(section, "duration: 1.0"))
    says = rf"{section}: holds nothing for {namespace}/plant; a section /\*\*/plant is for"
    with pytest.raises(BadInputError, match=says):
        load_configuration(path, namespace)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "must be a ROS parameter file"),
        ("[1, 2]", "must be a ROS parameter file"),
        ("plant: [", "is not YAML"),
        ("plant: 3", "plant: must hold the key ros__parameters, only"),
        ("plant: {ros_parameters: {}}", "plant: must hold the key ros__parameters, only"),
        (parameters("plnt", "duration: 1.0"), "plnt: is not a node, must be one of plant"),
        (parameters("plant", "duraton: 1.0"), "duraton = 1.0: is not a parameter of this node"),
        (parameters("plant", "duraton: 1.0"), "did you mean duration?"),
        (parameters("plant", "duration: -1.0"), "duration = -1.0 s: must be 0 to 1e+09 s"),
        (parameters("plant", "duration: .nan"), "duration = nan s: must be"),
        (parameters("plant", "duration: 10"), "duration = 10: must be written with a decimal"),
        (parameters("plant", "duration: long"), "duration = 'long': must be a number"),
        (parameters("plant", "mode: warp"), "mode = 'warp': must be one of lockstep, realtime"),
        (parameters("plant", "control_rate: 300.0"), "control_rate = 300.0 Hz: must divide"),
        (parameters("plant", "gap.table_times: [0.0, 1]"), "must be written with a decimal"),
        (parameters("plant", "gap.table_times: 1.0"), "gap.table_times = 1.0: must be a list"),
        (parameters("twin", "reconfigure: 'yes'"), "reconfigure = 'yes': must be true or false"),
        (parameters("twin", "estimator.delay: 2.0"), "estimator.delay = 2.0: must be an integer"),
    ],
)
def test_a_mistake_is_named_with_file_key_value_and_what_is_allowed(tmp_path, text, says):
    path = written(tmp_path, text)
    with pytest.raises(BadInputError) as caught:
        load_configuration(path)
    assert says in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_missing_a_folder_or_not_text_is_one_line(tmp_path):
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00\x81")
    for path in (tmp_path / "none.yaml", tmp_path, binary):
        with pytest.raises(BadInputError, match=r"cannot be read|is not YAML") as caught:
            load_configuration(path)
        assert "\n" not in str(caught.value)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda children: st.lists(children) | st.dictionaries(st.text(), children),
    max_leaves=8,
)


@given(st.dictionaries(st.sampled_from([*CONFIGURED_NODES, "/**", "x"]), json_values))
def test_whatever_stands_in_a_file_the_answer_is_a_configuration_or_one_line(
    tmp_path_factory, document
):
    wrapped = {node: {"ros__parameters": value} for node, value in document.items()}
    path = tmp_path_factory.mktemp("any") / "any.yaml"
    path.write_text(yaml.safe_dump(wrapped))
    try:
        load_configuration(path)
    except BadInputError as error:
        line = str(error)
    else:
        line = ""
    assert "\n" not in line


def test_the_packaged_configurations_are_those_of_the_folder_that_people_copy_from():
    packaged = packaged_configurations()
    assert {path.name for path in packaged.values()} == {x.name for x in CONFIG.glob("*.yaml")}
    for path in packaged.values():
        assert path.read_bytes() == (CONFIG / path.name).read_bytes(), path


def test_a_file_comes_before_a_packaged_configuration_of_that_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "paper").write_text(parameters("plant", "duration: 1.0"))
    assert find_configuration("paper") == Path("paper")
    assert load_configuration(find_configuration("paper")).value("plant", "duration") == 1.0


def test_a_file_that_is_missing_is_called_a_file():
    with pytest.raises(BadInputError, match=r"configuration no/paper\.yaml: cannot be read"):
        load_configuration(find_configuration("no/paper.yaml"))


def test_a_driver_in_place_of_the_plant_has_parameters_that_only_its_class_knows(tmp_path):
    text = parameters("driver", "{driver: 'my:Drive', drive: {port: x, gain: 2}}")
    configuration = load_configuration(written(tmp_path, text))
    assert configuration.machine == "driver"
    assert configuration.value("driver", "drive.port") == "x"
    assert configuration.value("driver", "control_rate") == 500.0


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (parameters("driver", "{}") + parameters("plant", "{}"), "choose it with --machine"),
        (parameters("driver", "{drve.port: x}"), "is not a parameter of this node"),
        (parameters("driver", "{control_rate: 0.1}"), "control_rate = 0.1 Hz: must be 1 to 10000"),
    ],
)
def test_a_driver_is_checked_like_any_node(tmp_path, text, line):
    with pytest.raises(BadInputError, match=line):
        load_configuration(written(tmp_path, text))


def test_of_a_file_with_two_machines_one_is_chosen(tmp_path):
    text = parameters("driver", "{driver: 'my:Drive'}") + parameters("plant", "{duration: 3.0}")
    path = written(tmp_path, text)
    driven = load_configuration(path, machine="driver")
    assert (driven.machine, driven.value("driver", "driver")) == ("driver", "my:Drive")
    simulated = load_configuration(path, machine="plant")
    assert (simulated.machine, simulated.value("plant", "duration")) == ("plant", 3.0)
    with pytest.raises(BadInputError, match="--machine driver: needs a --config"):
        load_configuration(None, machine="driver")
