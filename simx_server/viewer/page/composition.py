"""Composes the page, and keeps it up to date. One thread owns it; what people click goes through `Hands`."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Sequence
from typing import Protocol

import viser

from simx_server.viewer.messages import Look, Survey

from .keys import Keys
from .link import AGAIN, Away, Eye, Hands
from .mirror import Mirror
from .panels.cameras import Cameras
from .panels.clients import Clients
from .panels.interface import Interface
from .panels.joints import Joints
from .panels.objects import Objects
from .panels.run import Run
from .panels.signals import Signals
from .world import World

logger = logging.getLogger(__name__)

LOOKS = 1 / 25
"""Seconds between two looks at the scene."""

SURVEYS = 0.2
"""Seconds between two updates of the panels."""

PANEL_WIDTH = 440
"""Pixels: the controls stand in one row each."""

UNSEEN = 0.5
"""Seconds between two looks while no browser is there."""


class Panel(Protocol):
    """What stands in a tab."""

    def update(self, survey: Survey, look: Look) -> None:
        """News from the server, a few times a second; on the page's thread."""
        ...

    def close(self) -> None:
        """The page ends."""
        ...


class Page:
    """A page that viser serves. `run` until `end`."""

    def __init__(self, browser: viser.ViserServer, address: str) -> None:
        self._browser = browser
        self._eye = Eye(address)
        self._hands = hands = Hands(address, self._tell)
        mirror = Mirror()
        self._ending = threading.Event()
        gui = browser.gui
        gui.configure_theme(
            show_logo=False, show_share_button=False, control_width="large", brand_color=(31, 111, 139)
        )
        gui.set_panel_label("simx")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL_WIDTH)
        self._run = Run(gui, hands, address)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Objects"):
            objects = Objects(gui, hands)
        with tabs.add_tab("Joints"):
            keys = Keys(gui, hands)
            joints = Joints(gui, hands)
        with tabs.add_tab("Cameras"):
            self._cameras = Cameras(browser, hands, address, mirror)
        with tabs.add_tab("Signals"):
            signals = Signals(gui, hands, mirror)
        with tabs.add_tab("Dialogs"):
            interface = Interface(gui, hands)
        with tabs.add_tab("Clients"):
            clients = Clients(gui)
        with tabs.add_tab("View"):
            self._world = World(browser, hands, mirror)
        self._panels: Sequence[Panel] = (
            self._run,
            objects,
            keys,
            joints,
            self._cameras,
            signals,
            interface,
            clients,
        )

    def run(self) -> None:
        """Keep the page up to date until `end`."""
        next_survey = 0.0
        is_away = False
        while not self._ending.is_set():
            began = time.monotonic()
            pause = LOOKS if self._browser.get_clients() else UNSEEN
            try:
                look = self._eye.look()
                self._world.update(look)
                self._cameras.follow()
                if began >= next_survey:
                    survey = self._eye.survey()
                    self._world.survey(survey)
                    for panel in self._panels:
                        panel.update(survey, look)
                    next_survey = began + max(SURVEYS, pause)
                is_away = False
            except Away as reason:
                if not is_away:
                    logger.warning("%s; the page tries again every second", reason)
                is_away = True
                self._run.away(str(reason))
                pause = AGAIN
            self._browser.flush()
            self._ending.wait(max(0.0, began + pause - time.monotonic()))

    def end(self) -> None:
        """Let `run` return. Any thread."""
        self._ending.set()

    def close(self) -> None:
        for panel in self._panels:
            panel.close()
        self._hands.close()
        self._eye.close()

    def _tell(self, problem: str) -> None:
        """Something that was clicked could not be done: every browser says so for a while."""
        logger.warning("%s", problem)
        for client in self._browser.get_clients().values():
            client.add_notification("This was not done", problem, color="red", auto_close_seconds=10)
