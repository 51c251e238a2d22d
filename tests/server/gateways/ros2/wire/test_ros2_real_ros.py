"""Bytes, defaults and hashes of messages are those of real ROS 2: the wheels of Kilted on the package index."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

import pytest
from random_messages import made, plain
from real_ros import packages_of, real_hashes, ros_folder, through_ros

from simx_server.ros2_messages import BUILT_IN, KnownTypes, MessageType, Types, known_types, read_packages
from simx_server.ros2_messages.own import _Reader

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def ros() -> Path:
    return ros_folder()


@pytest.fixture(scope="module")
def known(ros: Path) -> KnownTypes:
    """The server's types, and those of ROS 2's own packages, such as test_msgs."""
    return known_types(read_packages([ros / "share"]))


def kinds(types: Types, packages: set[str]) -> Iterator[tuple[str, MessageType]]:
    """All messages of packages, those of services and actions included."""
    parts = (part for service in types.services.values() for part in (service.request, service.response))
    for kind in (*types.messages.values(), *parts):
        if kind.name.split("/")[0] in packages:
            yield kind.name, kind


def test_hashes_are_those_that_ros_own_generator_wrote(ros: Path, known: KnownTypes) -> None:
    real, types = real_hashes(ros), {**known.newer.messages, **known.newer.services}
    assert {name: types[name].hash for name in types if name in real} == {
        name: real[name] for name in types if name in real
    }
    compared = sum(name in real for name in types)
    assert compared > 150
    assert sum(name in real for name in (*BUILT_IN.newer.messages, *BUILT_IN.newer.services)) > 120


def test_ros_reads_our_bytes_and_we_read_its(ros: Path, known: KnownTypes) -> None:
    rng = random.Random(0)
    packages = packages_of(ros)
    wanted = [(kind, made(kind.layout, rng)) for _, kind in kinds(known.newer, packages) for _ in range(4)]
    answers = through_ros([(kind.name, value, kind.encode(value)) for kind, value in wanted])
    assert len(wanted) > 800
    for (kind, value), (read, written) in zip(wanted, answers, strict=True):
        if kind.layout.fields:  # ROS 2 gives other messages a field that has no meaning
            assert read == value, kind
        assert plain(kind.decode(written)) == value, kind
        # ROS 2 may leave padding at the end, and does not set its bytes to 0.
        assert len(written) >= len(kind.encode(value)), kind


def test_defaults_are_those_of_ros(ros: Path, known: KnownTypes) -> None:
    wanted = [kind for _, kind in kinds(known.newer, packages_of(ros))]
    answers = through_ros([(kind.name, None, kind.encode({})) for kind in wanted])
    for kind, (_, written) in zip(wanted, answers, strict=True):
        assert plain(kind.decode(written)) == plain(kind.decode(kind.encode({}))), kind


def test_the_servers_definitions_are_those_of_ros(ros: Path) -> None:
    texts = read_packages([ros / "share"])
    reader = _Reader(texts, {})
    compared = 0
    for name, kind in BUILT_IN.newer.messages.items():
        if name in texts:
            reader.read(name)
            compared += 1
            assert reader.found[name] == kind.layout
    assert compared > 100
