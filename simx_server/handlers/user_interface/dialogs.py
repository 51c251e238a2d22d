"""Dialogs. How they are answered is in `user_interface/dialogs.py` of the server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.handlers.registry import handler

if TYPE_CHECKING:
    from simx_server.world.world import World


@handler("simxDisplayDialog")
def display_dialog(
    world: World,
    title: str,
    text: str,
    dialog_type: int,
    initial_text: str,
    title_colors: list[float] | None,
    dialog_colors: list[float] | None,
) -> tuple[int, int]:
    """The dialog's handle and that of the custom UI it is made of.

    Differs: it needs no window; any program that looks at the simulation may answer it.
    """
    dialog = world.user_interface.dialogs.display(
        title, text, dialog_type, initial_text, title_colors, dialog_colors
    )
    return dialog.handle, dialog.ui.handle


@handler("simxEndDialog")
def end_dialog(world: World, handle: int) -> None:
    world.user_interface.dialogs.end(handle)


@handler("simxGetDialogResult")
def get_dialog_result(world: World, handle: int) -> int:
    """sim_dlgret_still_open until it is answered; then the answer, until the dialog or the run ends."""
    return world.user_interface.dialogs.get(handle).result


@handler("simxGetDialogInput")
def get_dialog_input(world: World, handle: int) -> str:
    """Return the text in the edit box; '' for a dialog without one."""
    return world.user_interface.dialogs.get(handle).input
