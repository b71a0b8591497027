"""Parameters of a node, as its parameter events tell them."""

from types import SimpleNamespace

from bdt_bags.reading.parameter_log import recorded_parameters

FIELDS = ("bool_value", "integer_value", "double_value", "string_value")


def parameter(name, kind, value):
    values = dict.fromkeys(FIELDS) | ({FIELDS[kind - 1]: value} if kind <= 4 else {})
    return SimpleNamespace(name=name, value=SimpleNamespace(type=kind, **values))


def event(node, new=(), changed=()):
    return SimpleNamespace(node=node, new_parameters=new, changed_parameters=changed)


def test_the_last_value_of_each_type_that_is_no_array():
    events = [
        event("/twin", [parameter("reconfigure", 1, False), parameter("estimator.delay", 2, 3)]),
        event("/twin", [parameter("estimator.kind", 4, "output_error")]),
        event("/twin", [parameter("structure.mass", 3, 5.2), parameter("list", 8, [1.0])]),
        event("/a/twin", [parameter("structure.damping", 3, 9.0)]),
        event("/twin", changed=[parameter("structure.mass", 3, 5.3)]),
    ]
    assert recorded_parameters(events, "/twin") == {
        "reconfigure": False,
        "estimator.delay": 3,
        "estimator.kind": "output_error",
        "structure.mass": 5.3,
    }
