"""The service definitions of Jazzy, which rosbags' type store does not carry.

One entry a service, in the ``.srv`` format without comments (they do not enter the type hash).
"""

from typing import Final

SERVICE_DEFINITIONS: Final[dict[str, str]] = {
    "diagnostic_msgs/srv/AddDiagnostics": """
string load_namespace
---
bool success
string message
""",
    "diagnostic_msgs/srv/SelfTest": """
---
string id
byte passed
diagnostic_msgs/DiagnosticStatus[] status
""",
    "nav_msgs/srv/GetMap": """
---
nav_msgs/OccupancyGrid map
""",
    "nav_msgs/srv/GetPlan": """
geometry_msgs/PoseStamped start
geometry_msgs/PoseStamped goal
float32 tolerance
---
nav_msgs/Path plan
""",
    "nav_msgs/srv/LoadMap": """
string map_url
---
uint8 RESULT_SUCCESS=0
uint8 RESULT_MAP_DOES_NOT_EXIST=1
uint8 RESULT_INVALID_MAP_DATA=2
uint8 RESULT_INVALID_MAP_METADATA=3
uint8 RESULT_UNDEFINED_FAILURE=255
nav_msgs/OccupancyGrid map
uint8 result
""",
    "nav_msgs/srv/SetMap": """
nav_msgs/OccupancyGrid map
geometry_msgs/PoseWithCovarianceStamped initial_pose
---
bool success
""",
    "rcl_interfaces/srv/DescribeParameters": """
string[] names
---
rcl_interfaces/ParameterDescriptor[] descriptors
""",
    "rcl_interfaces/srv/GetLoggerLevels": """
string[] names
---
rcl_interfaces/LoggerLevel[] levels
""",
    "rcl_interfaces/srv/GetParameters": """
string[] names
---
rcl_interfaces/ParameterValue[] values
""",
    "rcl_interfaces/srv/GetParameterTypes": """
string[] names
---
uint8[] types
""",
    "rcl_interfaces/srv/ListParameters": """
uint64 DEPTH_RECURSIVE=0
string[] prefixes
uint64 depth
---
rcl_interfaces/ListParametersResult result
""",
    "rcl_interfaces/srv/SetLoggerLevels": """
rcl_interfaces/LoggerLevel[] levels
---
rcl_interfaces/SetLoggerLevelsResult[] results
""",
    "rcl_interfaces/srv/SetParameters": """
rcl_interfaces/Parameter[] parameters
---
rcl_interfaces/SetParametersResult[] results
""",
    "rcl_interfaces/srv/SetParametersAtomically": """
rcl_interfaces/Parameter[] parameters
---
rcl_interfaces/SetParametersResult result
""",
    "sensor_msgs/srv/SetCameraInfo": """
sensor_msgs/CameraInfo camera_info
---
bool success
string status_message
""",
    "std_srvs/srv/Empty": """
---
""",
    "std_srvs/srv/SetBool": """
bool data
---
bool success
string message
""",
    "std_srvs/srv/Trigger": """
---
bool success
string message
""",
    "type_description_interfaces/srv/GetTypeDescription": """
string type_name
string type_hash
bool include_type_sources true
---
bool successful
string failure_reason
type_description_interfaces/TypeDescription type_description
type_description_interfaces/TypeSource[] type_sources
type_description_interfaces/KeyValue[] extra_information
""",
    "visualization_msgs/srv/GetInteractiveMarkers": """
---
uint64 sequence_number
visualization_msgs/InteractiveMarker[] markers
""",
}
