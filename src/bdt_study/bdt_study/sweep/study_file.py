"""Study files: YAML that is checked whole before anything runs."""

from collections.abc import Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import yaml

from bdt_controller.reference import ReferenceProfile
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.configuration_files import find_configuration
from bdt_msgs_py.parameter_files import ROS_PARAMETERS
from bdt_msgs_py.parameter_tables import check_value, known_parameters, suggestion
from bdt_msgs_py.quantities import Quantity
from bdt_msgs_py.topics import CONTROLLER_NODE, PLANT_NODE, TWIN_NODE
from bdt_plant.limits import HardwareLimits
from bdt_plant.plant import Sampling
from bdt_plant.plant_settings import PlantSettings
from bdt_study.calibration.start_values import read_configuration
from bdt_study.simulation.configured_loop import TABLES, LoopParameters, part_of
from bdt_study.sweep.axis import DISTRIBUTIONS, Axis
from bdt_study.sweep.run_batch import changes_of
from bdt_study.sweep.run_quantities import quantity_of
from bdt_study.sweep.run_result import REFERENCES
from bdt_study.sweep.study import NO_TWIN, Study
from bdt_twin.estimator_choice import EstimatorChoice
from bdt_twin.twin_settings import TwinSettings

KEYS = (
    "configuration",
    "duration",
    "estimator",
    "set",
    "vary",
    "sample",
    "repetitions",
    "seed",
    "compute",
)
"""What a study file may hold."""

DURATION = 120.0
"""Simulated time of a run [s] where neither study nor configuration tells one."""
MOST_VALUES = 100_000
"""Longest grid of one parameter."""

OF_PROCESSES = (PlantSettings, HardwareLimits, Sampling, TwinSettings)
"""Parameters that are about how nodes run, and rates, which all nodes have in common."""
VARIED_ALL_THE_SAME = ("telemetry_period", "reconfigure", "compensate_offset")
"""Those of them that matter to a loop."""


def packaged_studies() -> dict[str, Path]:
    """Return the studies that come with this package, by name."""
    folder = Path(str(files("bdt_study") / "studies"))
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def read_study(name: str | Path) -> Study:
    """Read and check a study file.

    Parameters
    ----------
    name : str or Path
        The file, or the name of a study that comes with the package; a file of that very name
        comes first.

    Raises
    ------
    BadInputError
        With one line that names file, key, value and what is allowed.
    """
    path, packaged = Path(name), packaged_studies()
    if not path.exists() and not path.suffix and str(name) not in packaged:
        raise BadInputError(
            f"{name}: is no file, and no study of the package: must be one of "
            f"{', '.join(packaged)}{suggestion(str(name), packaged)}"
        )
    if not path.exists():
        path = packaged.get(str(name), path)
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInputError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise BadInputError(f"{path}: is not YAML: {error}") from error
    try:
        return study_of(document, path)
    except ValueError as error:
        text = str(error)
        raise BadInputError(text if text.startswith(str(path)) else f"{path}: {text}") from error


def study_of(document: Any, path: Path) -> Study:
    """Return the study that a document describes.

    Parameters
    ----------
    document : Any
        What stands in the file.
    path : Path
        The file: a configuration is looked for beside it.

    Raises
    ------
    ValueError
        With one line that names key, value and what is allowed.
    """
    given = _mapping("the study", document)
    for key in given:
        if key not in KEYS:
            raise ValueError(f"{key}: must be one of {', '.join(KEYS)}{suggestion(key, KEYS)}")
    settings = _configured(given.get("configuration"), path)
    duration = settings.get(f"{PLANT_NODE}.duration") or DURATION
    for name, value in _mapping("set", given.get("set") or {}).items():
        settings[name] = _checked(name, value, "set")
    axes = tuple(_axis(name, content) for name, content in _varied(given.get("vary")))
    sample = _mapping("sample", given.get("sample") or {})
    if unknown := set(sample) - {"method", "count"}:
        raise ValueError(f"sample.{min(unknown)}: must be method or count")
    estimator = given.get("estimator", settings.get(f"{TWIN_NODE}.estimator.kind"))
    study = Study(
        name=path.stem,
        settings=tuple(sorted((name, _frozen(value)) for name, value in settings.items())),
        duration=_number("duration", given.get("duration", duration)),
        estimator=str(estimator or EstimatorChoice().kind),
        axes=axes,
        method=sample.get("method", "sobol"),
        samples=sample.get("count", 1),
        repetitions=given.get("repetitions", 1),
        seed=given.get("seed", 0),
        compute=_texts("compute", given.get("compute", list(Study.compute))),
    )
    _check_together(study)
    return study


def _configured(name: Any, path: Path) -> dict[str, Any]:
    """Return the values of a configuration by node and flat name."""
    if name is None:
        return {}
    beside = path.parent / str(name)
    found = beside if beside.is_file() else find_configuration(str(name))
    values = read_configuration(found or beside)
    return {
        f"{node}.{flat}": value
        for node, table in TABLES.items()
        for flat, value in values[node].items()
        if flat in known_parameters(table) and flat not in ROS_PARAMETERS
    }


def _varied(vary: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Iterate over the parameters that are varied, each of them once."""
    seen: set[str] = set()
    for name, content in _mapping("vary", vary or {}).items():
        details = _mapping(f"vary: {name}", content)
        for one in (name, *_texts(f"vary: {name}: also", details.get("also", []))):
            if one in seen:
                raise ValueError(f"vary: {one}: is varied twice")
            seen.add(one)
        yield name, details


def _axis(name: str, content: Mapping[str, Any]) -> Axis:
    _parameter(name, "vary")
    also = tuple(content.get("also", ()))
    kinds = [key for key in content if key != "also"]
    forms = f"values, from with to and count, {', '.join(DISTRIBUTIONS)}"
    if kinds == ["values"]:
        values = content["values"]
        if not isinstance(values, list) or not values:
            raise ValueError(f"vary: {name}: values = {values!r}: must be a list")
        axis = Axis(name, tuple(map(_frozen, values)), also=also)
    elif sorted(kinds) == ["count", "from", "to"]:
        axis = Axis(name, _linear(name, content), also=also)
    elif len(kinds) == 1 and kinds[0] in DISTRIBUTIONS:
        first, second = _pair(f"vary: {name}: {kinds[0]}", content[kinds[0]])
        axis = Axis(name, distribution=kinds[0], first=first, second=second, also=also)
    else:
        given = ", ".join(map(str, kinds)) or "nothing"
        raise ValueError(f"vary: {name}: {given}: must be {forms}")
    if len(axis.values) > MOST_VALUES:
        raise ValueError(f"vary: {name}: {len(axis.values)} values: must be at most {MOST_VALUES}")
    for one in axis.names:
        for value in axis.extremes:
            _checked(one, list(value) if isinstance(value, tuple) else value, "vary")
    return axis


def _linear(name: str, content: Mapping[str, Any]) -> tuple[float, ...]:
    count = content["count"]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 < count <= MOST_VALUES:
        raise ValueError(f"vary: {name}: count = {count!r}: must be 2 to {MOST_VALUES}")
    first, last = (_number(f"vary: {name}: {key}", content[key]) for key in ("from", "to"))
    # One by one: numpy's own division may round as suits the processor.
    return tuple(first + (last - first) * (place / (count - 1)) for place in range(count))


def _check_together(study: Study) -> None:
    """Check what goes together: quantities with the twin, values with each other."""
    for quantity in map(quantity_of, study.compute):
        if quantity.needs_twin and not study.has_twin:
            raise ValueError(f"compute: {quantity.name}: needs an estimator, which is {NO_TWIN}")
    if len(set(study.compute)) < len(study.compute):
        raise ValueError(f"compute = {list(study.compute)}: names a quantity twice")
    base = LoopParameters.from_values(study.node_values())
    starts = [axis.extremes[0] for axis in study.axes]
    for place, axis in enumerate(study.axes):
        for value in axis.extremes:
            values = [*starts[:place], value, *starts[place + 1 :]]
            _check_loop(study, base.with_values(changes_of(study.axes, values)))
    _check_loop(study, base)


def _check_loop(study: Study, parameters: LoopParameters) -> None:
    parameters.scenario(study.duration)
    kind = parameters.part(CONTROLLER_NODE, "reference", ReferenceProfile).kind
    if kind not in REFERENCES:
        raise ValueError(
            f"controller.reference.kind = {kind!r}: must be one of {', '.join(REFERENCES)}"
        )


def _checked(name: str, value: Any, key: str) -> Any:
    """Return the value of a parameter if it is allowed."""
    default, described = _parameter(name, key)
    check_value(f"{key}: {name}", value, default, described)
    return value


def _parameter(name: str, key: str) -> tuple[Any, Quantity]:
    """Return default and quantity of a parameter by node and flat name."""
    known = {
        f"{node}.{flat}": told
        for node, table in TABLES.items()
        for flat, told in known_parameters(table).items()
        if part_of(node, flat)[0][2] not in OF_PROCESSES or flat in VARIED_ALL_THE_SAME
    }
    if name not in known:
        raise ValueError(
            f"{key}: {name}: is not a parameter of a loop, with its node in front"
            f"{suggestion(str(name), known)}"
        )
    return known[name]


def _mapping(label: str, content: Any) -> Mapping[str, Any]:
    if not isinstance(content, dict):
        raise ValueError(f"{label}: must be names with values")
    return {str(name): value for name, value in content.items()}


def _texts(label: str, content: Any) -> tuple[str, ...]:
    if not isinstance(content, list) or not all(isinstance(one, str) for one in content):
        raise ValueError(f"{label} = {content!r}: must be a list of names")
    return tuple(content)


def _pair(label: str, content: Any) -> tuple[float, float]:
    if not isinstance(content, list) or len(content) != 2:
        raise ValueError(f"{label} = {content!r}: must be a list of two numbers")
    first, second = (_number(label, one) for one in content)
    return first, second


def _number(label: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{label} = {value!r}: must be a number")
    return float(value)


def _frozen(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
