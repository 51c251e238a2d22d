"""Hashes of types, which stand in keys (RIHS01), as ROS 2's REP-2016 prescribes.

A hash is SHA-256 over JSON of the type's description and of those that it refers to, sorted by name.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

from .layouts import Field, Layout, WideString
from .primitives import Primitive

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
_NESTED, _STRING, _BOUND = 1, 17, 4
_ARRAY, _BOUNDED, _SEQUENCE = 48, 96, 144

_TIME = "builtin_interfaces/msg/Time"
_EVENT_INFO = "service_msgs/msg/ServiceEventInfo"


def _described(
    name: str, number: int, capacity: int = 0, nested: str = "", longest: int = 0
) -> dict[str, Any]:
    kind = {
        "type_id": number,
        "capacity": capacity,
        "string_capacity": longest,
        "nested_type_name": nested,
    }
    return {"name": name, "type": kind}


class TypeHashes:
    """The hashes of all types of a set of layouts, each computed when it is first needed."""

    def __init__(self, layouts: Mapping[str, Layout]) -> None:
        self._layouts = layouts
        self._known: dict[str, list[dict[str, Any]]] = {}
        """Type descriptions by name."""

        self._made: dict[str, str] = {}

    def of(self, name: str) -> str:
        """Return the hash of a message or service, such as `RIHS01_a13e…`."""
        if name not in self._made:
            if name in self._layouts:
                self._add(self._layouts[name])
            else:
                self._add_service(name)
            self._made[name] = f"RIHS01_{self._digest(name)}"
        return self._made[name]

    def _digest(self, name: str) -> str:
        others = sorted(self._referred(name, set()) - {name})
        text = json.dumps(
            {
                "type_description": {"type_name": name, "fields": self._known[name]},
                "referenced_type_descriptions": [
                    {"type_name": other, "fields": self._known[other]} for other in others
                ],
            }
        )
        return sha256(text.encode()).hexdigest()

    def _referred(self, name: str, seen: set[str]) -> set[str]:
        if name not in seen:
            seen.add(name)
            for field in self._known[name]:
                nested = field["type"]["nested_type_name"]
                if nested:
                    self._referred(nested, seen)
        return seen

    def _add(self, layout: Layout) -> None:
        if layout.name not in self._known:
            self._known[layout.name] = [self._field(field) for field in layout.fields] or [
                _described("structure_needs_at_least_one_member", _NUMBERS["uint8"])
            ]

    def _field(self, field: Field) -> dict[str, Any]:
        above = 0 if field.count is None else _ARRAY if field.count else _BOUNDED if field.most else _SEQUENCE
        capacity = field.count or field.most
        if isinstance(field.kind, Layout):
            self._add(field.kind)
            return _described(field.name, above + _NESTED, capacity, field.kind.name)
        if isinstance(field.kind, Primitive):
            return _described(field.name, above + _NUMBERS[field.kind.name], capacity)
        number = _STRING + (field.kind is WideString) + (_BOUND if field.longest else 0)
        return _described(field.name, above + number, capacity, longest=field.longest)

    def _add_service(self, name: str) -> None:
        """Add a service: a type of three fields, the last of which is the type of its events."""
        request, response, event = (f"{name}_{end}" for end in ("Request", "Response", "Event"))
        self._add(self._layouts[request])
        self._add(self._layouts[response])
        self._add(self._layouts[_TIME])
        self._known[_EVENT_INFO] = [
            _described("event_type", _NUMBERS["uint8"]),
            _described("stamp", _NESTED, nested=_TIME),
            _described("client_gid", _ARRAY + _NUMBERS["char"], 16),
            _described("sequence_number", _NUMBERS["int64"]),
        ]
        self._known[event] = [
            _described("info", _NESTED, nested=_EVENT_INFO),
            _described("request", _BOUNDED + _NESTED, 1, request),
            _described("response", _BOUNDED + _NESTED, 1, response),
        ]
        self._known[name] = [
            _described(f"{end}_message", _NESTED, nested=f"{name}_{end.capitalize()}")
            for end in ("request", "response", "event")
        ]
