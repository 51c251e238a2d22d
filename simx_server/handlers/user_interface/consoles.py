"""Auxiliary consoles. `user_interface/consoles.py` of the server implements them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.world.world import World


@handler("simxAuxiliaryConsoleOpen")
def open_console(
    world: World,
    title: str,
    max_lines: int,
    mode: int,
    position: list[int] | None,
    size: list[int] | None,
    text_color: list[float] | None,
    background_color: list[float] | None,
) -> int:
    """Return a different handle for every console.

    Differs: the original without a window gave every console the handle 1.
    """
    console = world.user_interface.consoles.open(
        title, max_lines, mode, position, size, text_color, background_color
    )
    return console.handle


@handler("simxAuxiliaryConsoleClose")
def close_console(world: World, handle: int) -> None:
    """Ignore an unknown handle, as V-REP does."""
    world.user_interface.consoles.close(handle)


@handler("simxAuxiliaryConsolePrint")
def print_to_console(world: World, handle: int, text: str | None) -> None:
    """Ignore a console that is closed.

    Raises:
        CommandError: this handle never belonged to a console.
    """
    world.user_interface.consoles.print(handle, text)


@handler("simxAuxiliaryConsoleShow")
def show_console(world: World, handle: int, shown: bool) -> None:
    """Raises CommandError as for printing."""
    world.user_interface.consoles.show(handle, shown)
