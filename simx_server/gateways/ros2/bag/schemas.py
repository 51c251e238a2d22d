"""The definitions of messages as texts in the form of ROS 2's own files, which MCAP files carry."""

from __future__ import annotations

from simx_server.ros2_messages.layouts import Field, Layout, WideString
from simx_server.ros2_messages.primitives import Primitive

_LINE = "=" * 80


def definition(layout: Layout) -> str:
    """Return the definition of a message, followed by those of all messages within it."""
    found: dict[str, Layout] = {}
    _collect(layout, found)
    parts = [_fields(layout)]
    for name, each in found.items():
        if name != layout.name:
            parts.append(f"{_LINE}\nMSG: {_short(name)}\n{_fields(each)}")
    return "".join(parts)


def _collect(layout: Layout, found: dict[str, Layout]) -> None:
    if layout.name not in found:
        found[layout.name] = layout
        for field in layout.fields:
            if isinstance(field.kind, Layout):
                _collect(field.kind, found)


def _fields(layout: Layout) -> str:
    return "".join(f"{_type(field)} {field.name}\n" for field in layout.fields)


def _type(field: Field) -> str:
    if isinstance(field.kind, Layout):
        name = _short(field.kind.name)
    else:
        name = field.kind.name if isinstance(field.kind, Primitive) else _string(field)
    if field.count is None:
        return name
    return f"{name}[{f'<={field.most}' if field.most else field.count or ''}]"


def _string(field: Field) -> str:
    name = "wstring" if field.kind is WideString else "string"
    return f"{name}<={field.longest}" if field.longest else name


def _short(name: str) -> str:
    """Return the name of a type as definitions have it: `std_msgs/Header`."""
    package, _, last = name.split("/")
    return f"{package}/{last}"
