"""Dialogs. `user_interface/dialogs.py` of the server explains how they are answered."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler

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
    """Return the handle of the dialog and the handle of its custom UI.

    Differs: no window is needed; any program that shows the simulation may answer the dialog.
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
    """Return sim_dlgret_still_open until the dialog is answered; then the answer, until the dialog or the run ends."""
    return world.user_interface.dialogs.get(handle).result


@handler("simxGetDialogInput")
def get_dialog_input(world: World, handle: int) -> str:
    """Return '' for a dialog without an edit box."""
    return world.user_interface.dialogs.get(handle).input
