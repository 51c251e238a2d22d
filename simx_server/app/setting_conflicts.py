"""Settings that are good by themselves and do not go together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .setting_rules import SettingError

if TYPE_CHECKING:
    from .settings import Settings

_OF_SERVERS = (
    "ports",
    "start",
    "auto_start",
    "temporary_port",
    "speed",
    "quit_after_stop",
    "listen",
    "connect",
    "config",
    "multicast_scouting",
    "realm",
    "view",
)
"""Fields without a meaning where nobody is served."""


DECISIVE = ("time_step", "arguments", "command_server", "allow_code", "limit")
"""Fields that decide what a simulation does, beside its scene: a recording holds them, for its replays."""


def refuse_conflicts(settings: Settings) -> None:
    """Raise SettingError for the first two that do not go together. Variables may say what only other runs need."""
    for refuse in (
        _refuse_repeated_ports,
        _refuse_impossible_count,
        _refuse_impossible_recording,
        _refuse_impossible_pictures,
        _refuse_what_nobody_is_served,
    ):
        refuse(settings)


def _refuse_repeated_ports(settings: Settings) -> None:
    chosen = [port for port in settings.ports if port]
    repeated = sorted({port for port in chosen if chosen.count(port) > 1})
    if repeated:
        raise SettingError(
            f"{settings.origins['ports']}: {repeated[0]} is given twice; "
            "valid: each port once, 0 as often as you like"
        )


def _refuse_impossible_count(settings: Settings) -> None:
    if settings.count is None:
        return
    if settings.listen:
        raise SettingError(
            f"{settings.origins['listen']}: with --count all servers would listen on the same endpoint; "
            "valid: --connect to a router that others reach, or no --count"
        )
    if settings.view:
        raise SettingError(
            f"{settings.origins['view']}: with --count all servers would want the same page; "
            "valid: one of both, and for one of many: python -m simx_server.viewer 127.0.0.1:PORT"
        )
    if max(settings.member(settings.count - 1).ports) > 65535:
        raise SettingError(
            f"{settings.origins['count']}: the ports of {settings.count} servers go beyond 65535; "
            "valid: fewer, lower ports, or --port 0 for free ones"
        )


def _refuse_impossible_recording(settings: Settings) -> None:
    if settings.record and settings.count is not None:
        raise SettingError(
            f"{settings.origins['record']}: with --count all servers would write the same file; "
            "valid: one of both"
        )
    if settings.replay and (settings.record or settings.scene or settings.count is not None):
        raise SettingError(
            f"{settings.origins['replay']}: a recording brings its scene, and a replay is not recorded; "
            "valid: no SCENE, --record or --count beside it"
        )


def _refuse_impossible_pictures(settings: Settings) -> None:
    """A snapshot is no server, and a film is one server's."""
    others = {"snapshot": ("video", "state_log", "record"), "video": (), "state_log": ()}
    others["save_mjcf"] = (*others, "record", "replay")
    for name, more in others.items():
        if getattr(settings, name) is None:
            continue
        for other in (*more, "count"):
            if getattr(settings, other) is not None:
                flag = "--" + other.replace("_", "-")
                raise SettingError(
                    f"{settings.origins[name]}: does not go together with {flag}; valid: one of both"
                )
    if settings.snapshot or settings.video or settings.state_log:
        return
    for name in ("camera", "size", "fps"):
        if settings.origins.get(name, "").startswith("flag"):
            raise SettingError(
                f"{settings.origins[name]}: nothing is pictured; valid: with --snapshot, --video or --state-log"
            )


def _refuse_what_nobody_is_served(settings: Settings) -> None:
    """A replay and a snapshot leave when they are done, and the one has its settings from the recording."""
    if settings.replay:
        beside, meaningless = "--replay", (*_OF_SERVERS, *DECISIVE, "workspace", "package", "duration")
        needed = {"allow_code"}  # a recording may ask for it
        needed |= {"duration"} if settings.snapshot else set()
    elif settings.snapshot:
        beside, meaningless, needed = "--snapshot", _OF_SERVERS, set[str]()
    elif settings.save_mjcf:
        beside, needed = "--save-mjcf", set[str]()
        meaningless = (*_OF_SERVERS, *DECISIVE, "workspace", "duration")
    else:
        return
    for name in meaningless:
        if name not in needed and settings.origins.get(name, "").startswith("flag"):
            raise SettingError(
                f"{settings.origins[name]}: has no meaning beside {beside}; valid: one of both"
            )
