"""Physical quantities as dataclass fields: default, unit, range and meaning in one place.

A parameter set is a frozen dataclass whose fields are made with :func:`quantity`. The field is the
only place where the default, the unit, the allowed range and the description stand: the
dataclass checks itself with :func:`validate`, the ROS parameter descriptors and the tables in the
documentation are derived from the same field.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields
from itertools import pairwise
from typing import Any

_METADATA_KEY = "quantity"


@dataclass(frozen=True)
class Quantity:
    """What is known about a parameter besides its value.

    Attributes
    ----------
    unit : str
        SI unit, "" for a dimensionless value or a choice.
    description : str
        One sentence in the words of the field.
    minimum, maximum : float or None
        Smallest and largest allowed value, both inclusive.
    choices : tuple of str
        Allowed texts; empty when every text is allowed.
    reconfigurable : bool
        True when the value may change while a node runs.
    """

    unit: str
    description: str
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[str, ...] = ()
    reconfigurable: bool = False

    @property
    def is_free(self) -> bool:
        """Whether every value of the right type is allowed."""
        return not self.choices and self.minimum is None and self.maximum is None

    def allowed(self) -> str:
        """Return what is allowed, as a phrase for messages and tables."""
        if self.choices:
            return "one of " + ", ".join(self.choices)
        unit = f" {self.unit}" if self.unit else ""
        if self.minimum is not None and self.maximum is not None:
            return f"{self.minimum:g} to {self.maximum:g}{unit}"
        if self.minimum is not None:
            return f"at least {self.minimum:g}{unit}"
        if self.maximum is not None:
            return f"at most {self.maximum:g}{unit}"
        return "any"

    def rule(self, kind: str) -> str:
        """Return what a value of a kind, "a text" for example, has to be, as a phrase."""
        return kind if self.is_free else f"{kind}, {self.allowed()}"


def quantity(
    default: Any,
    unit: str,
    description: str,
    *,
    minimum: float | None = None,
    maximum: float | None = None,
    choices: tuple[str, ...] = (),
    reconfigurable: bool = False,
) -> Any:
    """Return a dataclass field that carries a :class:`Quantity`.

    Parameters
    ----------
    default : bool, int, float, str or tuple
        Default value; its type is the type of the parameter.
    unit, description, minimum, maximum, choices, reconfigurable
        See :class:`Quantity`.

    Returns
    -------
    dataclasses.Field
        Typed ``Any`` because it stands where the value will be.
    """
    described = Quantity(unit, description, minimum, maximum, choices, reconfigurable)
    return field(default=default, metadata={_METADATA_KEY: described})


def quantities_of(parameters: Any) -> Iterator[tuple[str, Any, Quantity]]:
    """Iterate over ``(name, default, quantity)`` of a parameter dataclass or an instance of one."""
    for item in fields(parameters):
        described = item.metadata.get(_METADATA_KEY)
        if described is not None:
            yield item.name, item.default, described


def check(label: str, value: Any, default: Any, described: Quantity) -> None:
    """Check one value against its quantity.

    Parameters
    ----------
    label : str
        Name used in the message, for example ``motor.inductance``.
    value : bool, int, float, str or sequence
        The value to check.
    default : same type as `value`
        Tells the required type; of a tuple, the first item does.
    described : Quantity
        Tells the required range.

    Raises
    ------
    ValueError
        With one line that names the field, the value and what is allowed.
    """
    if isinstance(default, tuple):
        if isinstance(value, (str, bytes)) or not isinstance(value, Sequence):
            raise ValueError(f"{label} = {value!r}: must be a list")
        for index, item in enumerate(value):
            check(f"{label}[{index}]", item, default[0], described)
    elif isinstance(default, bool):
        if not isinstance(value, bool):
            raise ValueError(f"{label} = {value!r}: must be true or false")
    elif isinstance(default, str):
        if not isinstance(value, str) or (described.choices and value not in described.choices):
            raise ValueError(f"{label} = {value!r}: must be {_text_rule(described)}")
    elif isinstance(default, int):
        if isinstance(value, bool) or not isinstance(value, int):
            raise ValueError(f"{label} = {value!r}: must be {described.rule('an integer')}")
        _check_number(label, value, described)
    else:
        _check_number(label, value, described)


def validate(parameters: Any) -> None:
    """Check every field of a parameter dataclass; call it from ``__post_init__``.

    Raises
    ------
    ValueError
        For the first field outside its range, with the field, the value and what is allowed.
    """
    for name, default, described in quantities_of(parameters):
        label = f"{type(parameters).__name__}.{name}"
        check(label, getattr(parameters, name), default, described)


def validate_table(parameters: Any, abscissa: str, ordinate: str) -> None:
    """Check two fields that together are a table; call it from ``__post_init__``.

    Parameters
    ----------
    parameters : dataclass instance
        Its fields `abscissa` and `ordinate` are tuples of float.
    abscissa, ordinate : str
        Names of the fields.

    Raises
    ------
    ValueError
        If the lengths differ or are zero, or the abscissa does not increase strictly.
    """
    owner = type(parameters).__name__
    points, values = getattr(parameters, abscissa), getattr(parameters, ordinate)
    if len(points) != len(values) or not points:
        raise ValueError(
            f"{owner}.{ordinate} has {len(values)} values: "
            f"must have as many as {abscissa} ({len(points)}), at least one"
        )
    if any(after <= before for before, after in pairwise(points)):
        raise ValueError(f"{owner}.{abscissa} = {list(points)}: must be strictly increasing")


def _text_rule(described: Quantity) -> str:
    return described.allowed() if described.choices else "a text"


def _check_number(label: str, value: Any, described: Quantity) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{label} = {value!r}: must be {described.rule('a number')}")
    low = -math.inf if described.minimum is None else described.minimum
    high = math.inf if described.maximum is None else described.maximum
    # Compared before math.isfinite, which overflows for huge integers; NaN fails the comparison.
    if not low <= value <= high or not math.isfinite(value):
        unit = f" {described.unit}" if described.unit else ""
        raise ValueError(f"{label} = {value!r}{unit}: must be {described.allowed()}")
