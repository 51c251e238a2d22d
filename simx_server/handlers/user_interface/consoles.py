"""Auxiliary consoles. What they do is in `user_interface/consoles.py` of the server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.handlers.registry import handler

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
    """Open a text console; every console has a different handle.

    Differs: the original without a window gave every console the handle 1.
    """
    console = world.user_interface.consoles.open(
        title, max_lines, mode, position, size, text_color, background_color
    )
    return console.handle


@handler("simxAuxiliaryConsoleClose")
def close_console(world: World, handle: int) -> None:
    """An unknown handle succeeds, as in V-REP."""
    world.user_interface.consoles.close(handle)


@handler("simxAuxiliaryConsolePrint")
def print_to_console(world: World, handle: int, text: str | None) -> None:
    """To a console that was closed: nothing, and no error.

    Raises:
        CommandError: there never was a console with this handle.
    """
    world.user_interface.consoles.print(handle, text)


@handler("simxAuxiliaryConsoleShow")
def show_console(world: World, handle: int, shown: bool) -> None:
    """Raises CommandError as for printing."""
    world.user_interface.consoles.show(handle, shown)
