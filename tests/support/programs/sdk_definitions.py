# pyright: reportMissingImports=false
"""Definitions of types for the package zenoh-ros2-sdk, which would fetch them with git.

The standard ones come from rosbags; the SDK computes all hashes.
"""

from __future__ import annotations

import re
from pathlib import Path

from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)

_FOLDER = Path(__file__).parents[3] / "simx_server" / "ros2_messages" / "definitions"
_PACKAGES = ("simulation_interfaces", "control_msgs")
"""Packages that rosbags lacks."""


def more_definitions() -> dict[str, str]:
    """Return the messages of the packages that rosbags lacks, as files of ROS 2 have them."""
    found: dict[str, str] = {}
    for package in _PACKAGES:
        text = (_FOLDER / f"{package}.txt").read_text(encoding="utf-8")
        for section in re.split(r"\n(?=\w)", re.sub(r" *#.*", "", text).strip()):
            name, *lines = [line.strip() for line in section.splitlines() if line.strip()]
            if "---" not in lines:
                fields = [line for line in lines if "=" not in line]
                found[f"{package}/msg/{name}"] = "\n".join(
                    line if line[0].islower() else f"{package}/{line}" for line in fields
                )
    return found


def write_definitions(folder: Path) -> None:
    """Write all definitions as files of packages."""
    definitions = more_definitions()
    for kind in STORE.fielddefs:
        definitions[kind] = STORE.generate_msgdef(kind, ros_version=2)[0].split("=" * 80)[0]
    for kind, text in definitions.items():
        package, _, name = kind.split("/")
        path = folder / package / "msg" / f"{name}.msg"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
