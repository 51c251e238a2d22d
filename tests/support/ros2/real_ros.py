"""Real ROS 2, from wheels on the package index, as tests use it: its own messages, definitions and type hashes.

The wheels are those of the distribution Kilted for Python 3.11 on Linux. They have no middleware for Zenoh.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from other_clients import client_folder
from processes import ROOT

from simx_client.protocol.cli.installing import line

ROS = "ros-rclpy==9.1.2"
PACKAGES = (
    *("rmw-fastrtps-cpp==9.3.3", "test-msgs==2.3.0", "std-msgs==5.5.1", "geometry-msgs==5.5.1"),
    *("sensor-msgs==5.5.1", "nav-msgs==5.5.1", "trajectory-msgs==5.5.1", "diagnostic-msgs==5.5.1"),
    "std-srvs==5.5.1",
)
PROGRAM = ROOT / "tests" / "support" / "programs" / "rclpy_bytes.py"
TIMEOUT = 120.0


def ros_folder() -> Path:
    """Return the folder of ROS 2; skip the test if it is not installed."""
    folder = client_folder(ROS)
    if not folder.is_dir():
        wanted = [ROS, *(f"ros-{each}" for each in PACKAGES)]
        pytest.skip(f"ROS 2 is not installed: {line(wanted)} --prefix .clients/{ROS}")
    return folder


def environment(folder: Path) -> dict[str, str]:
    """Return the environment in which Python finds ROS 2 and its libraries."""
    (packages,) = folder.glob("lib/python3.*/site-packages")
    libraries = [folder / "lib", *packages.glob("ros_*.libs")]
    return {
        **os.environ,
        "PYTHONPATH": str(packages),
        "LD_LIBRARY_PATH": os.pathsep.join(map(str, libraries)),
        "AMENT_PREFIX_PATH": str(folder),
        "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",  # else the wheels replace the process by one with such an environment
    }


def packages_of(folder: Path) -> set[str]:
    """Return the names of the packages that have messages."""
    return {each.parent.name for kind in ("msg", "srv", "action") for each in folder.glob(f"share/*/{kind}")}


def real_hashes(folder: Path) -> Mapping[str, str]:
    """Return all type hashes that ROS 2's own generator has written, by the names of the types."""
    found: dict[str, str] = {}
    for path in folder.glob("share/*/*/*.json"):
        for each in json.loads(path.read_text())["type_hashes"] if path.parent.name in KINDS else ():
            found[each["type_name"]] = each["hash_string"]
    return found


KINDS = ("msg", "srv", "action")


def through_ros(jobs: Sequence[tuple[str, Mapping[str, Any] | None, bytes]]) -> list[tuple[Any, bytes]]:
    """Have ROS 2 read bytes and write values; see `programs/rclpy_bytes.py`."""
    done = subprocess.run(
        [sys.executable, str(PROGRAM)],
        input=json.dumps([(name, value, data.hex()) for name, value, data in jobs]),
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=TIMEOUT,
        env=environment(ros_folder()),
    )
    return [(value, bytes.fromhex(data)) for value, data in json.loads(done.stdout)]
