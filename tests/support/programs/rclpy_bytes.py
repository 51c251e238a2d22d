# pyright: reportMissingImports=false, reportUnknownVariableType=false, reportUnknownMemberType=false
# pyright: reportUnknownArgumentType=false, reportUnknownParameterType=false
"""Real ROS 2 writes and reads the bytes of messages, in a separate process: its libraries need an environment.

    python rclpy_bytes.py < JOBS > ANSWERS

Jobs are a list of JSON: `[TYPE, VALUE, BYTES]`, with the bytes in hexadecimal; VALUE null: the defaults. Answers are a
list of the same length: `[VALUE, BYTES]`, what ROS 2 reads from the bytes, and what it writes for the value.
"""

from __future__ import annotations

import array
import json
import sys
from importlib import import_module
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from rosidl_parser.definition import NamespacedType


def class_of(name: str) -> Any:
    package, kind, short = name.split("/")
    module = import_module(f"{package}.{kind}")
    for end in ("_Request", "_Response") if kind == "srv" else ():
        if short.endswith(end):
            return getattr(getattr(module, short.removesuffix(end)), end[1:])
    if kind == "action":
        for end in ("_SendGoal_Request", "_SendGoal_Response", "_GetResult_Request", "_GetResult_Response"):
            if short.endswith(end):
                service, part = end[1:].split("_")
                action = getattr(module, short.removesuffix(end))
                return getattr(getattr(action.Impl, f"{service}Service"), part)
        return getattr(module, short.removesuffix("_FeedbackMessage")).Impl.FeedbackMessage
    return getattr(module, short)


def fill(message: Any, values: dict[str, Any]) -> None:
    kinds = dict(zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True))
    for field, value in values.items():
        before, kind = getattr(message, field), kinds[field]
        if isinstance(value, dict):
            fill(before, value)
        elif isinstance(getattr(kind, "value_type", None), NamespacedType):
            inner = class_of("/".join(kind.value_type.namespaced_name()))
            made = [inner() for _ in value]
            for each, one in zip(made, value, strict=True):
                fill(each, one)
            setattr(message, field, made)
        elif isinstance(before, bytes):
            setattr(message, field, bytes([value]))
        elif isinstance(before, list) and getattr(kind.value_type, "typename", "") == "octet":
            setattr(message, field, [bytes([one]) for one in value])
        else:
            setattr(message, field, value)


def plain(value: Any) -> Any:
    if hasattr(value, "get_fields_and_field_types"):
        return {field: plain(getattr(value, field)) for field in value.get_fields_and_field_types()}
    if isinstance(value, np.ndarray | array.array):
        return value.tolist()
    if isinstance(value, bytes):
        return value[0]
    return [plain(each) for each in value] if isinstance(value, list) else value


def answer(name: str, values: dict[str, Any] | None, data: str) -> tuple[Any, str]:
    kind = class_of(name)
    message = kind()
    if values is not None:
        fill(message, values)
    return plain(deserialize_message(bytes.fromhex(data), kind)), bytes(serialize_message(message)).hex()


json.dump([answer(*job) for job in json.load(sys.stdin)], sys.stdout)
