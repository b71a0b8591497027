"""Parameters: a name, a type and a value."""

from embedded_ros.parameter_files import (
    get_parameter_value,
    parameter_dict_from_yaml_file,
    parameter_value_to_python,
)
from embedded_ros.parameter_selection import SEPARATOR as PARAMETER_SEPARATOR_STRING
from embedded_ros.parameter_value import Parameter
from embedded_ros.public_names import shown_in

__all__ = [
    "PARAMETER_SEPARATOR_STRING",
    "Parameter",
    "get_parameter_value",
    "parameter_dict_from_yaml_file",
    "parameter_value_to_python",
]

shown_in(__name__, Parameter, Parameter.Type)
