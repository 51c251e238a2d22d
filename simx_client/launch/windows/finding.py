"""Select the screen for windows of this process: the display, else the web viewer of its server, else none."""

from __future__ import annotations

import atexit
import logging
import os
from typing import Any, Protocol

from simx_client.connection.clients import CLIENTS

from . import display
from .screen import Lost, NoScreen, Report, Screen
from .viewer import Viewer

logger = logging.getLogger(__name__)

ADVICE = (
    "no image is shown and no key comes; the script goes on (waitKey returns -1 after its time, waitKey(0) at once). "
    "To see them, run the script on a desktop or through 'ssh -X', or start the server with --view and open the web "
    "viewer; or save them with cv2.imwrite"
)


class Ended(Protocol):
    """Notified of the end of the process, and of a fork."""

    def close(self) -> None: ...
    def forget(self) -> None: ...


class Finder:
    """Finds a screen. The display is tried once, and the web viewer once for each connection of the script."""

    def __init__(self, cv2: Any) -> None:
        self._cv2 = cv2
        self._start()

    def _start(self) -> None:
        self._reasons: list[str] = []
        """Reasons for a missing screen found so far."""

        self._has_tried_display = self._has_told = False
        self._asked: set[int] = set()
        """Connections, by identity, whose server was requested."""

    def ends_with(self, gui: Ended) -> None:
        """Close it when the process exits, and start again in a forked child."""
        atexit.register(gui.close)
        if hasattr(os, "register_at_fork"):  # Windows cannot fork
            os.register_at_fork(after_in_child=gui.forget)
            os.register_at_fork(after_in_child=self._start)

    def find(self, report: Report, lost: Lost) -> Screen:
        """Return a screen. Raises NoScreen; its text is empty if the reason was logged before."""
        if not self._has_tried_display:
            self._has_tried_display = True
            try:
                return display.Display(report, lost)
            except NoScreen as reason:
                self._reasons.append(str(reason))
        for connection in CLIENTS.all():
            if id(connection) not in self._asked and connection.connection_id != -1:
                self._asked.add(id(connection))
                try:
                    screen = Viewer(self._cv2, connection.where, report, lost)
                except NoScreen as reason:
                    self._reasons.append(str(reason))
                else:
                    logger.warning("%s, so windows of cv2 are shown %s", self._reasons[0], screen.name)
                    return screen
        if self._has_told:
            raise NoScreen("")
        self._has_told = True
        raise NoScreen(f"{'; '.join(self._reasons)}; {ADVICE}")
