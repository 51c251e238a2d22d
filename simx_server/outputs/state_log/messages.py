"""The messages of a state log: Foxglove's schemas where there is one, and a few of ours; all in protobuf.

Every schema is in the file, so a viewer can show numbers and texts without knowing the schemas.
"""

from __future__ import annotations

from typing import Any

from simx_server.outputs.packages import package

FOXGLOVE = ("FrameTransforms", "JointStates", "Log", "SceneUpdate", "CompressedImage")

OWN: dict[str, dict[str, str]] = {
    "Simulation": {
        "state": "string",
        "scene": "string",
        "run": "uint32",
        "pass_count": "uint32",
        "time": "double",
        "time_step": "double",
    },
    "IntegerSignal": {"value": "int64", "is_set": "bool"},
    "FloatSignal": {"value": "double", "is_set": "bool"},
    "StringSignal": {"value": "string", "is_set": "bool"},
}
"""Name to fields and their types; the first field of each is the time. `is_set` is false when a signal was cleared."""

_TYPES = {"double": 1, "int64": 3, "bool": 8, "string": 9, "uint32": 13}
"""Numbers from protobuf's `FieldDescriptorProto.Type`; a message is 11."""


class Messages:
    """The classes of all messages, by the schema's full name, and the schemas themselves."""

    def __init__(self) -> None:
        """Load the classes. Raises OutputError: a package is missing."""
        self._classes = {
            f"foxglove.{name}": getattr(_package(f"foxglove_schemas_protobuf.{name}_pb2"), name)
            for name in FOXGLOVE
        }
        for name, message in _own_classes().items():
            self._classes[f"simx.{name}"] = message

    def new(self, schema: str) -> Any:
        """Return an empty message."""
        return self._classes[schema]()

    def schema(self, name: str) -> bytes:
        """Return a `FileDescriptorSet` with the message and all its parts, serialised."""
        files = _package("google.protobuf.descriptor_pb2").FileDescriptorSet()
        seen: set[str] = set()

        def add(descriptor: Any) -> None:
            if descriptor.name in seen:
                return
            seen.add(descriptor.name)
            for needed in descriptor.dependencies:
                add(needed)
            descriptor.CopyToProto(files.file.add())

        add(self._classes[name].DESCRIPTOR.file)
        return files.SerializeToString()


def _package(name: str) -> Any:
    return package(name, "--state-log", "log")


def _own_classes() -> dict[str, Any]:
    descriptors = _package("google.protobuf.descriptor_pb2")
    timestamp = _package("google.protobuf.timestamp_pb2").DESCRIPTOR
    file = descriptors.FileDescriptorProto(
        name="simx/state_log.proto", package="simx", syntax="proto3", dependency=[timestamp.name]
    )
    for name, fields in OWN.items():
        message = file.message_type.add(name=name)
        message.field.add(
            name="timestamp", number=1, type=11, label=1, type_name=".google.protobuf.Timestamp"
        )
        for number, (field, kind) in enumerate(fields.items(), 2):
            message.field.add(name=field, number=number, type=_TYPES[kind], label=1)
    pool = _package(
        "google.protobuf.descriptor_pool"
    ).DescriptorPool()  # a separate one: other logs have the same
    pool.AddSerializedFile(timestamp.serialized_pb)
    pool.AddSerializedFile(file.SerializeToString())
    get_class = _package("google.protobuf.message_factory").GetMessageClass
    return {name: get_class(pool.FindMessageTypeByName(f"simx.{name}")) for name in OWN}


def plain(text: str) -> str:
    """Return a text that protobuf and MCAP accept: invalid characters from old programs become question marks."""
    return text.encode("utf-8", "replace").decode()


def set_time(timestamp: Any, time_ns: int) -> None:
    """Write nanoseconds since 1970 into a `google.protobuf.Timestamp`."""
    timestamp.seconds, timestamp.nanos = divmod(time_ns, 1_000_000_000)
