"""Signals."""

from __future__ import annotations

import viser

from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.link import Hands


class Signals:
    """To be written."""

    def __init__(self, gui: viser.GuiApi, hands: Hands) -> None:
        self._hands = hands
        self._text = gui.add_markdown("nothing yet")

    def update(self, survey: Survey, look: Look) -> None:
        """News."""

    def close(self) -> None:
        """Nothing to end."""
