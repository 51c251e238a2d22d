"""Messages of ROS with default values, as tables: what `simROS2.createInterface` returns.

A definition is a list of fields, `type name`; a type that ends in `[]` or `[N]` is an array. Only the messages of
common packages are here.
"""

from __future__ import annotations

import re
from typing import Any

_ARRAY = re.compile(r"(?P<item>[\w/]+)\[(?P<count>\d*)\]$")
_NUMBERS = re.compile(r"u?int\d+|byte|char")

_DEFINITIONS = {
    "builtin_interfaces/Time": "int32 sec, uint32 nanosec",
    "builtin_interfaces/Duration": "int32 sec, uint32 nanosec",
    "rosgraph_msgs/Clock": "Time clock",
    "std_msgs/Header": "Time stamp, string frame_id",
    "std_msgs/ColorRGBA": "float32 r, float32 g, float32 b, float32 a",
    "std_msgs/Empty": "",
    "std_msgs/MultiArrayDimension": "string label, uint32 size, uint32 stride",
    "std_msgs/MultiArrayLayout": "MultiArrayDimension[] dim, uint32 data_offset",
    "geometry_msgs/Vector3": "float64 x, float64 y, float64 z",
    "geometry_msgs/Point": "float64 x, float64 y, float64 z",
    "geometry_msgs/Point32": "float32 x, float32 y, float32 z",
    "geometry_msgs/Quaternion": "float64 x, float64 y, float64 z, float64 w",
    "geometry_msgs/Pose": "Point position, Quaternion orientation",
    "geometry_msgs/Pose2D": "float64 x, float64 y, float64 theta",
    "geometry_msgs/PoseStamped": "Header header, Pose pose",
    "geometry_msgs/PoseWithCovariance": "Pose pose, float64[36] covariance",
    "geometry_msgs/PoseArray": "Header header, Pose[] poses",
    "geometry_msgs/Twist": "Vector3 linear, Vector3 angular",
    "geometry_msgs/TwistStamped": "Header header, Twist twist",
    "geometry_msgs/TwistWithCovariance": "Twist twist, float64[36] covariance",
    "geometry_msgs/Wrench": "Vector3 force, Vector3 torque",
    "geometry_msgs/WrenchStamped": "Header header, Wrench wrench",
    "geometry_msgs/Transform": "Vector3 translation, Quaternion rotation",
    "geometry_msgs/TransformStamped": "Header header, string child_frame_id, Transform transform",
    "geometry_msgs/PointStamped": "Header header, Point point",
    "tf2_msgs/TFMessage": "TransformStamped[] transforms",
    "nav_msgs/Odometry": "Header header, string child_frame_id, PoseWithCovariance pose, TwistWithCovariance twist",
    "nav_msgs/Path": "Header header, PoseStamped[] poses",
    "sensor_msgs/JointState": "Header header, string[] name, float64[] position, float64[] velocity, float64[] effort",
    "sensor_msgs/Image": (
        "Header header, uint32 height, uint32 width, string encoding, uint8 is_bigendian, uint32 step, uint8[] data"
    ),
    "sensor_msgs/CompressedImage": "Header header, string format, uint8[] data",
    "sensor_msgs/CameraInfo": (
        "Header header, uint32 height, uint32 width, string distortion_model, float64[] d, float64[9] k, float64[9] r, "
        "float64[12] p, uint32 binning_x, uint32 binning_y"
    ),
    "sensor_msgs/LaserScan": (
        "Header header, float32 angle_min, float32 angle_max, float32 angle_increment, float32 time_increment, "
        "float32 scan_time, float32 range_min, float32 range_max, float32[] ranges, float32[] intensities"
    ),
    "sensor_msgs/Range": (
        "Header header, uint8 radiation_type, float32 field_of_view, float32 min_range, float32 max_range, "
        "float32 range"
    ),
    "sensor_msgs/Imu": (
        "Header header, Quaternion orientation, float64[9] orientation_covariance, Vector3 angular_velocity, "
        "float64[9] angular_velocity_covariance, Vector3 linear_acceleration, "
        "float64[9] linear_acceleration_covariance"
    ),
    "sensor_msgs/NavSatStatus": "int8 status, uint16 service",
    "sensor_msgs/NavSatFix": (
        "Header header, NavSatStatus status, float64 latitude, float64 longitude, float64 altitude, "
        "float64[9] position_covariance, uint8 position_covariance_type"
    ),
    "sensor_msgs/PointField": "string name, uint32 offset, uint8 datatype, uint32 count",
    "sensor_msgs/PointCloud2": (
        "Header header, uint32 height, uint32 width, PointField[] fields, bool is_bigendian, uint32 point_step, "
        "uint32 row_step, uint8[] data, bool is_dense"
    ),
    "trajectory_msgs/JointTrajectoryPoint": (
        "float64[] positions, float64[] velocities, float64[] accelerations, float64[] effort, Duration time_from_start"
    ),
    "trajectory_msgs/JointTrajectory": "Header header, string[] joint_names, JointTrajectoryPoint[] points",
}

_PLAIN = {
    **{name: name.lower() for name in ("Bool", "Float32", "Float64", "String", "Byte", "Char")},
    **{f"{sign}{bits}": f"{sign}{bits}".lower() for sign in ("Int", "UInt") for bits in (8, 16, 32, 64)},
}
_DEFINITIONS.update({f"std_msgs/{name}": f"{kind} data" for name, kind in _PLAIN.items()})
_DEFINITIONS.update(
    {f"std_msgs/{name}MultiArray": f"MultiArrayLayout layout, {kind}[] data" for name, kind in _PLAIN.items()}
)
_BY_NAME = {name.partition("/")[2]: name for name in reversed(_DEFINITIONS)}


def supported_messages() -> list[str]:
    """Return the types of all messages, as ROS 2 names them."""
    return sorted(name.replace("/", "/msg/") for name in _DEFINITIONS)


def default_message(kind: str) -> dict[str, Any] | None:
    """Return a message with default values; None for an unknown type. `kind`: `std_msgs/msg/Bool`, `std_msgs::Bool`."""
    name = kind.replace("::", "/").replace("/msg/", "/")
    definition = _DEFINITIONS.get(name)
    if definition is None:
        return None
    found: dict[str, Any] = {}
    for field in filter(None, definition.split(", ")):
        type_, _, key = field.partition(" ")
        found[key] = _default(type_)
    return found


def _default(kind: str) -> Any:
    array = _ARRAY.match(kind)
    if array is not None:
        return [_default(array["item"]) for _ in range(int(array["count"] or 0))]
    if kind == "string":
        return ""
    if kind == "bool":
        return False
    if kind.startswith("float"):
        return 0.0
    if _NUMBERS.fullmatch(kind):
        return 0
    return default_message(_BY_NAME[kind])
