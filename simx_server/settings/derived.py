"""Settings that follow from those of another server: of one of several, and of a server that is started again."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from pathlib import Path

from .rules import next_address, port_of
from .settings import Settings


def of_member(settings: Settings, number: int) -> Settings:
    """Return the settings of one of ``--count`` servers, counted from 0: its ports follow those of the one before.

    With 19997 and 19999 the next has 20000 and 20002; 0 stays 0. A given realm becomes ``NAME-0``, ``NAME-1``. Each
    has a separate domain of ROS 2, the one after that of the server before.
    """
    fixed = [port for port in (*settings.ports, *map(port_of, settings.legacy_ports)) if port]
    offset = number * (max(fixed) - min(fixed) + 1) if fixed else 0
    return dataclasses.replace(
        settings,
        ports=tuple(port and port + offset for port in settings.ports),
        legacy_ports=tuple(next_address(address, offset) for address in settings.legacy_ports),
        temporary_port=settings.temporary_port + (offset if settings.temporary_port in fixed else 0),
        realm=settings.realm and f"{settings.realm}-{number}",
        ros2=None if settings.ros2 is None else settings.ros2 + number,
        zmq=settings.zmq and next_address(settings.zmq, number),
        zmq2=settings.zmq2 and next_address(settings.zmq2, number),
        count=None,
        supervised=settings.is_supervised,
    )


def at_ports(settings: Settings, ports: Sequence[int], endpoints: Sequence[str]) -> Settings:
    """Return the settings of a server at the ports that it has found.

    Args:
        settings: with which it has started.
        ports: of the server, in the order of `ports`.
        endpoints: all of its endpoints; others than Zenoh's start with the name of the gateway.
    """

    def found(name: str) -> list[str]:
        return [each.removeprefix(f"{name}/") for each in endpoints if each.startswith(f"{name}/")]

    return dataclasses.replace(
        settings,
        ports=tuple(ports),
        legacy_ports=tuple(found("legacy")),
        zmq=next(iter(found("zmq")), None),
        zmq_viewers=next(iter(found("zmq-viewers")), None),
        zmq2=next(iter(found("zmq2")), None),
        zmq2_viewers=next(iter(found("zmq2-viewers")), None),
    )


def of_start(settings: Settings, number: int) -> Settings:
    """Return the settings of a server that is started again, `number` times in all; its films are further files."""

    def further(path: Path | None) -> Path | None:
        return path and path.with_stem(f"{re.sub(r'-[0-9]+$', '', path.stem)}-{number}")

    return dataclasses.replace(
        settings,
        video=further(settings.video),
        state_log=further(settings.state_log),
        rosbag=further(settings.rosbag),
    )
