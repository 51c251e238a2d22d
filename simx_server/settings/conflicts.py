"""Refuse settings that are valid alone and do not go together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

from .derived import of_member
from .rules import LAST_ROS_DOMAIN, SettingError, port_of
from .settings import Settings

Conflicts = Iterator[tuple[str, str]]
"""Fields, and what is wrong with them."""

DECISIVE = (
    "time_step",
    "arguments",
    "seed",
    "planner",
    "command_server",
    "allow_code",
    "allow_machine",
    "limit",
    "history",
)
"""Fields that, beside the scene, determine a simulation: a recording stores them, for its replays."""


def refuse_conflicts(settings: Settings) -> None:
    """Raise SettingError for the first conflict. A variable may hold a setting that only other runs need."""
    for conflicts in (_ports, _count, _ros2, _recording, _images, _without_clients):
        for name, problem in conflicts(settings):
            raise SettingError(f"{settings.origins[name]}: {problem}")


def _is_flag(settings: Settings, name: str) -> bool:
    return settings.origins.get(name, "").startswith("flag")


def _ports(settings: Settings) -> Conflicts:
    chosen = [port for port in settings.ports if port]
    for port in sorted(port for port in chosen if chosen.count(port) > 1):
        yield "ports", f"{port} is given twice; valid: each port once, 0 as often as you like"
    legacy = [port for port in map(port_of, settings.legacy_ports) if port]
    for port in sorted(port for port in legacy if legacy.count(port) > 1):
        yield "legacy_ports", f"{port} is given twice; valid: each port once, 0 as often as you like"
    for port in sorted({*chosen} & {*legacy}):
        yield (
            "legacy_ports",
            (
                f"{port} is given with --port too, which is for clients of this project; "
                f"valid: another number for one of both"
            ),
        )


def _count(settings: Settings) -> Conflicts:
    if settings.count is None:
        return
    if settings.listen:
        yield (
            "listen",
            (
                "with --count all servers would listen on the same endpoint; "
                "valid: --connect to a router that others reach, or no --count"
            ),
        )
    for name in ("zmq_viewers", "zmq2_viewers"):
        if getattr(settings, name):
            yield name, "with --count all servers would want the same port; valid: one of both"
    if settings.view:
        yield (
            "view",
            (
                "with --count all servers would want the same page; "
                "valid: one of both, and for one of many: python -m simx_server.viewer 127.0.0.1:PORT"
            ),
        )
    last = of_member(settings, settings.count - 1)
    others = [*last.legacy_ports, *(each for each in (last.zmq, last.zmq2) if each)]
    if max(*last.ports, 0, *map(port_of, others)) > 65535:
        yield (
            "count",
            (
                f"the ports of {settings.count} servers go beyond 65535; "
                "valid: fewer, lower ports, or --port 0 for free ones"
            ),
        )


def _ros2(settings: Settings) -> Conflicts:
    if settings.ros2 is None:
        for name in ("ros2_namespace", "ros2_router", "ros2_distro", "ros2_drive"):
            is_of_bag = name == "ros2_drive" and settings.rosbag is not None
            if _is_flag(settings, name) and not is_of_bag:
                yield name, "has no meaning without a node of ROS 2; valid: with --ros2"
        return
    if settings.count is None:
        return
    if settings.ros2_router.startswith("self"):
        yield (
            "ros2_router",
            "with --count all servers would listen on the same endpoint; valid: the ENDPOINT of one router for all",
        )
    if settings.ros2 + settings.count - 1 > LAST_ROS_DOMAIN:
        yield (
            "ros2",
            f"the domains of {settings.count} servers go beyond {LAST_ROS_DOMAIN}; valid: fewer, or a lower domain",
        )


def _recording(settings: Settings) -> Conflicts:
    if settings.record and settings.count is not None:
        yield "record", "with --count all servers would write the same file; valid: one of both"
    if settings.replay and (settings.record or settings.scene or settings.count is not None):
        yield (
            "replay",
            (
                "a recording brings its scene, and a replay is not recorded; "
                "valid: no SCENE, --record or --count beside it"
            ),
        )


def _images(settings: Settings) -> Conflicts:
    """Yield conflicts of outputs: a snapshot does not serve, and a film belongs to one server."""
    others: dict[str, tuple[str, ...]] = {
        "snapshot": ("video", "state_log", "rosbag", "record"),
        "video": (),
        "state_log": (),
        "rosbag": (),
    }
    others["save"] = (*others, "record", "replay")
    others["save_mjcf"] = (*others, "record", "replay")
    others["convert"] = (*others, "record", "replay")
    for name, more in others.items():
        for other in (*more, "count"):
            if getattr(settings, name) is not None and getattr(settings, other) is not None:
                yield name, f"does not go together with --{other.replace('_', '-')}; valid: one of both"
    if not (settings.snapshot or settings.video or settings.state_log):
        for name in ("camera", "size", "fps"):
            if _is_flag(settings, name):
                yield name, "nothing is pictured; valid: with --snapshot, --video or --state-log"


def _without_clients(settings: Settings) -> Conflicts:
    """Yield settings without a meaning for runs without clients: such a run ends when it is done.

    A replay takes its settings from the recording.
    """
    of_servers = [each.name for each in fields(settings) if each.metadata and each.metadata["setting"].serves]
    of_replay = {*of_servers, *DECISIVE, "workspace", "duration", "ros2_messages"}
    if settings.replay:  # a recording may ask for code
        beside, meaningless = "--replay", (of_replay | {"package", "xacro"}) - {"allow_code"}
        meaningless -= {"duration"} if settings.snapshot else set()
    elif settings.snapshot or settings.save:
        beside, meaningless = "--snapshot" if settings.snapshot else "--save", set(of_servers)
    elif settings.save_mjcf or settings.convert:
        beside, meaningless = "--save-mjcf" if settings.save_mjcf else "--convert", of_replay
    else:
        return
    for name in (*of_servers, *DECISIVE, "workspace", "package", "xacro", "duration", "ros2_messages"):
        if name in meaningless and _is_flag(settings, name):
            yield name, f"has no meaning beside {beside}; valid: one of both"
