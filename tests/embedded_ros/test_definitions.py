"""Type hashes are those of Jazzy: others compare them with their own."""

import json
from hashlib import sha256

import pytest
from embedded_ros.definitions import fields_of, message_names, service_names, type_hash
from embedded_ros.endpoints import dds_type_name, ros_type_of
from embedded_ros.type_descriptions import describe
from rclpy.node import Node
from type_description_interfaces.srv import GetTypeDescription

# From the .json files of an installed Jazzy.
HASHES = {
    "std_msgs/msg/Char": "RIHS01_3ad2d04dd29ba19d04b16659afa3ccaedd691914b02a64e82e252f2fa6a586a9",
    "sensor_msgs/msg/JointState": (
        "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
    ),
    "std_msgs/msg/Float64MultiArray": (
        "RIHS01_1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f"
    ),
    "rcl_interfaces/srv/SetParameters_Request": (
        "RIHS01_130d46386b7e84ea9ecf60608a4d83cbe5e5cb7c6cc5b712b7a4e3a6c254e932"
    ),
}


@pytest.mark.parametrize(("name", "expected"), HASHES.items())
def test_hashes(name, expected):
    assert type_hash(name) == expected


def test_every_service_has_both_parts():
    for package in ("rcl_interfaces", "std_srvs", "sensor_msgs", "diagnostic_msgs", "nav_msgs"):
        for name in service_names(package):
            assert fields_of(f"{package}/srv/{name}_Request")
            assert fields_of(f"{package}/srv/{name}_Response")


def test_an_unknown_type_is_a_key_error():
    with pytest.raises(KeyError):
        fields_of("std_msgs/msg/Nothing")
    assert "Nothing" not in message_names("std_msgs")


def test_dds_type_names():
    assert dds_type_name("std_msgs/msg/Float64") == "std_msgs::msg::dds_::Float64_"
    assert ros_type_of("std_srvs::srv::dds_::Trigger_Request_") == "std_srvs/srv/Trigger_Request"
    assert ros_type_of("HelloWorld::Msg") == "HelloWorld::Msg"


def as_hashed(description):
    """Return what RIHS01 hashes: the description without default values, as JSON."""

    def individual(item):
        return {
            "type_name": item.type_name,
            "fields": [
                {
                    "name": field.name,
                    "type": {
                        name: getattr(field.type, name)
                        for name in ("type_id", "capacity", "string_capacity", "nested_type_name")
                    },
                }
                for field in item.fields
            ],
        }

    return json.dumps(
        {
            "type_description": individual(description.type_description),
            "referenced_type_descriptions": [
                individual(item) for item in description.referenced_type_descriptions
            ],
        }
    )


@pytest.mark.parametrize(
    "name", ["sensor_msgs/msg/CameraInfo", "rcl_interfaces/msg/ParameterEvent"]
)
def test_descriptions_of_types_have_the_hash_of_the_type(name):
    description, digest = describe(name)
    assert f"RIHS01_{sha256(as_hashed(description).encode()).hexdigest()}" == digest


def test_a_node_describes_the_types_it_uses(ros):
    node = ros.create(Node, "n")
    client = node.create_client(GetTypeDescription, "n/get_type_description")
    assert client.wait_for_service(20.0)
    request = GetTypeDescription.Request(type_name="rcl_interfaces/msg/ParameterEvent")
    response = ros.result(client.call_async(request))
    assert response.successful
    assert len(response.type_description.referenced_type_descriptions) == 3
    request.type_hash = "RIHS01_wrong"
    assert "hash" in ros.result(client.call_async(request)).failure_reason
    request.type_name = "std_msgs/msg/String"
    assert "not currently in use" in ros.result(client.call_async(request)).failure_reason
