"""The table of docs/ros2.md has each topic, service and action of the node, and claims no judge that there is not."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fnmatch import fnmatchcase
from typing import NamedTuple

import pytest
from processes import ROOT
from recorded_hashes import HASHES
from ros2_world import ros2_world

PAGE = ROOT / "docs" / "ros2.md"
SCENES = ("ur5_rg2_kinect", "ur5", "pioneer_p3dx", "quadricopter")
SCANNER = """<mujoco><worldbody><geom type="plane" size="1 1 .1"/>
<camera name="scanner" pos="0 0 1" resolution="32 1" output="depth"/></worldbody></mujoco>"""
"""It has a vision sensor with one row of pixels."""

NO_WHEELS = ("tf2_msgs", "control_msgs", "simulation_interfaces")
"""Packages that are not on the package index."""


class Row(NamedTuple):
    names: list[str]
    type: str
    judges: set[str]


def rows() -> Iterator[Row]:
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 3 and re.match(r"[RSPWB]( |$)", cells[2]) and "/" in cells[1]:
            names = re.findall(r"`([^`]+)`", cells[0])
            patterns = [re.sub("ACTION|SENSOR|ARM|GRIPPER", "*", name) for name in names]
            yield Row(patterns, cells[1], set(cells[2].partition(":")[0].split()))


@pytest.fixture(scope="module")
def offered(tmp_path_factory: pytest.TempPathFactory) -> set[tuple[str, str]]:
    """Names and types of the endpoints of several scenes."""
    found: set[tuple[str, str]] = set()
    for scene in (*(ROOT / "scenes" / f"{name}.xml" for name in SCENES), SCANNER):
        with ros2_world(tmp_path_factory.mktemp("page"), scene=scene) as server:
            endpoints = server.on_server(lambda server=server: server.gateway._endpoints())  # pyright: ignore[reportPrivateUsage]
            found |= {(each.full_name, each.described.name) for each in endpoints}
    return found


def test_each_topic_service_and_action_is_in_the_table(offered: set[tuple[str, str]]) -> None:
    table = list(rows())
    missing = [
        each
        for each in sorted(offered)
        if not any(
            fnmatchcase(each[1], row.type) and any(fnmatchcase(each[0], name) for name in row.names)
            for row in table
        )
    ]
    assert missing == []


def test_the_table_has_nothing_that_the_node_does_not_offer(offered: set[tuple[str, str]]) -> None:
    unknown = [
        (name, row.type)
        for row in rows()
        for name in row.names
        if not any(fnmatchcase(found, name) and fnmatchcase(kind, row.type) for found, kind in offered)
    ]
    assert unknown == []


def test_judges_are_claimed_where_they_have_the_types() -> None:
    for row in rows():
        package = row.type.partition("/")[0]
        assert ("W" in row.judges) is (package not in NO_WHEELS), row
        assert "B" not in row.judges or "/msg/" in row.type, row
        assert any(fnmatchcase(name, row.type) for name in HASHES), row
