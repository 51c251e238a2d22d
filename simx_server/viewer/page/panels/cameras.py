"""Cameras."""

from __future__ import annotations

import viser

from simx_server.viewer.messages import Look, Survey


class Cameras:
    """To be written."""

    def __init__(self, browser: viser.ViserServer, address: str) -> None:
        self._text = browser.gui.add_markdown("nothing yet")

    def update(self, survey: Survey, look: Look) -> None:
        """News."""

    def close(self) -> None:
        """Nothing to end."""
