"""Compute the hashes of types (RIHS01) from the server's layouts, as ROS 2's REP-2016 prescribes.

A hash is SHA-256 over JSON of the type's description and of those that it refers to, sorted by name.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

from simx_server.ros2_messages.layouts import Field, Layout
from simx_server.ros2_messages.primitives import Primitive

_NUMBERS = {
    "int8": 2,
    "uint8": 3,
    "char": 3,  # ROS 2 takes char for uint8
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "bool": 15,
    "byte": 16,
}
_STRING, _ARRAY, _BOUNDED, _SEQUENCE = 17, 48, 96, 144


def _described(name: str, number: int, capacity: int, nested: str = "") -> dict[str, Any]:
    kind = {"type_id": number, "capacity": capacity, "string_capacity": 0, "nested_type_name": nested}
    return {"name": name, "type": kind}


class Descriptions:
    """Type descriptions by name."""

    def __init__(self) -> None:
        self.known: dict[str, list[dict[str, Any]]] = {}

    def add(self, layout: Layout) -> None:
        if layout.name not in self.known:
            self.known[layout.name] = [self._field(field) for field in layout.fields] or [
                _described("structure_needs_at_least_one_member", _NUMBERS["uint8"], 0)
            ]

    def _field(self, field: Field) -> dict[str, Any]:
        above = 0 if field.count is None else _ARRAY if field.count else _BOUNDED if field.most else _SEQUENCE
        if isinstance(field.kind, Layout):
            self.add(field.kind)
            return _described(field.name, above + 1, field.count or field.most, field.kind.name)
        number = _NUMBERS[field.kind.name] if isinstance(field.kind, Primitive) else _STRING
        return _described(field.name, above + number, field.count or field.most)

    def add_service(self, name: str, layouts: Mapping[str, Layout]) -> None:
        """Add a service: a type of three fields, the last of which is the type of its events."""
        request, response, event = (f"{name}_{end}" for end in ("Request", "Response", "Event"))
        self.add(layouts[request])
        self.add(layouts[response])
        self.add(layouts["builtin_interfaces/msg/Time"])
        info = "service_msgs/msg/ServiceEventInfo"
        self.known[info] = [
            _described("event_type", _NUMBERS["uint8"], 0),
            _described("stamp", 1, 0, "builtin_interfaces/msg/Time"),
            _described("client_gid", _ARRAY + _NUMBERS["char"], 16),
            _described("sequence_number", _NUMBERS["int64"], 0),
        ]
        self.known[event] = [
            _described("info", 1, 0, info),
            _described("request", _BOUNDED + 1, 1, request),
            _described("response", _BOUNDED + 1, 1, response),
        ]
        self.known[name] = [
            _described(f"{end}_message", 1, 0, f"{name}_{end.capitalize()}")
            for end in ("request", "response", "event")
        ]

    def hash(self, name: str) -> str:
        """Return the hash of a type: 64 hexadecimal digits."""
        others = sorted(self._referred(name, set()) - {name})
        text = json.dumps(
            {
                "type_description": {"type_name": name, "fields": self.known[name]},
                "referenced_type_descriptions": [
                    {"type_name": other, "fields": self.known[other]} for other in others
                ],
            }
        )
        return sha256(text.encode()).hexdigest()

    def _referred(self, name: str, seen: set[str]) -> set[str]:
        if name not in seen:
            seen.add(name)
            for field in self.known[name]:
                nested = field["type"]["nested_type_name"]
                if nested:
                    self._referred(nested, seen)
        return seen


def computed_hashes(layouts: Mapping[str, Layout]) -> dict[str, str]:
    """Return the hashes of all messages and services of these layouts, by name."""
    descriptions = Descriptions()
    names: list[str] = []
    for name, layout in layouts.items():
        if "/msg/" in name or name.endswith("_FeedbackMessage"):
            descriptions.add(layout)
            names.append(name)
        elif name.endswith("_Response"):
            names.append(name.removesuffix("_Response"))
            descriptions.add_service(names[-1], layouts)
    return {name: descriptions.hash(name) for name in names}
