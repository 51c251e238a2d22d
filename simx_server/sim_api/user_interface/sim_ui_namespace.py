"""Assemble the namespace ``simUI``, which V-REP 3 offered as ``simExtCustomUI_`` too."""

from __future__ import annotations

from .sim_ui import UiWindowFunctions
from .sim_ui_dialogs import UiDialogFunctions
from .sim_ui_plots import UiImageFunctions, UiPlotFunctions, UiUnseenFunctions
from .sim_ui_tables import UiTableFunctions, UiTreeFunctions
from .sim_ui_values import UiComboboxFunctions, UiValueFunctions


class SimUi(
    UiWindowFunctions,
    UiValueFunctions,
    UiComboboxFunctions,
    UiTableFunctions,
    UiTreeFunctions,
    UiPlotFunctions,
    UiImageFunctions,
    UiUnseenFunctions,
    UiDialogFunctions,
):
    """All functions of ``simUI``, for one script."""

    PLUGIN = "simUI"
