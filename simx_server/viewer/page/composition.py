"""Compose the web viewer, and keep it up to date. One thread owns it; clicks go through `Hands`."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Protocol, TypeVar

import viser

from simx_server.viewer.messages import Look, Survey

from .guarded import Guarded
from .keys import Keys
from .link import AGAIN, Away, Eye, Hands
from .mirror import Mirror
from .panels.cameras import Cameras
from .panels.clients import Clients
from .panels.interface import Interface
from .panels.joints import Joints
from .panels.objects import Objects
from .panels.run import Run
from .panels.scripts import Scripts
from .panels.signals import Signals
from .panels.time_slider import TimeSlider
from .panels.views import FloatingViews
from .panels.windows import Windows
from .quiet_viser import renumber, set_title
from .style import PAGE_STYLE, PANEL_WIDTH
from .teleoperation.panel import Teleoperation
from .tools.address import Addresses
from .tools.files import Files
from .tools.gizmo import Gizmo
from .tools.shortcuts import Shortcuts
from .tools.shots import Shots
from .view.world import World

logger = logging.getLogger(__name__)

LOOKS = 1 / 25
"""Seconds between two updates of the scene."""

SURVEYS = 0.2
"""Seconds between two updates of the panels."""

UNSEEN = 0.5
"""Seconds between two updates while no browser is connected."""


class Panel(Protocol):
    """The content of a tab."""

    def update(self, survey: Survey, look: Look) -> None:
        """Show new data from the server, a few times per second; on the viewer's thread."""
        ...

    def close(self) -> None:
        """Release resources at the end of the viewer."""
        ...


P = TypeVar("P", bound=Panel)


class Page:
    """The web viewer's content, served by viser. `run` until `end`."""

    def __init__(self, browser: viser.ViserServer, address: str, arm: str | None = None) -> None:
        """Make the content for a server; `arm`: an operator drives this arm, or the first one if it is empty."""
        self._browser = browser
        self._eye = Eye(address)
        self._hands = hands = Hands(address, self._tell)
        self._mirror = mirror = Mirror()
        self._ending = threading.Event()
        gui = browser.gui
        gui.configure_theme(
            show_logo=False, show_share_button=False, control_width="large", brand_color=(31, 111, 139)
        )
        gui.set_panel_label("simx")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL_WIDTH)
        gui.add_html(PAGE_STYLE)
        self._title = ""
        self._parts: list[tuple[Guarded, Panel]] = []
        self._run = self._placed("the line of state", lambda: Run(gui, hands, address))
        self._slider = self._placed("the time slider", lambda: TimeSlider(gui, hands, self._report))
        addresses = self._placed(
            "the addresses of browsers",
            lambda: Addresses(
                browser,
                hands,
                self._slider.turn_to,
                lambda: self._slider.step,
                lambda: self._world.spare_shadows(),
            ),
        )
        self._is_kept = False
        """The server was asked to keep the past."""

        box = None if arm is None else Teleoperation.add_box(gui)
        self._teleoperation: Teleoperation | None = None
        self._view = Guarded(gui, "the 3-D view")
        self._sensed = Guarded(gui, "the readings of sensors in the 3-D view")
        self._surveyed = Guarded(gui, "what stands beside the bodies of the 3-D view")
        tabs = gui.add_tab_group()
        if arm is not None and box is not None:
            with tabs.add_tab("Drive"):
                self._teleoperation = self._placed(
                    "the tab of teleoperation", lambda: Teleoperation(browser, hands, arm, box)
                )
        with tabs.add_tab("Objects"):
            self._placed("the folder of files", lambda: Files(gui, hands))
            gizmo = Gizmo(browser, hands)
            self._placed("the tab of objects", lambda: Objects(gui, hands))
        with tabs.add_tab("Joints"):
            self._placed("the legend of keys", lambda: Keys(gui, hands))
            self._placed("the tab of joints", lambda: Joints(gui, hands))
        with tabs.add_tab("Cameras"):
            self._placed("the windows of scripts", lambda: Windows(browser, hands, address))
            self._cameras = self._placed(
                "the tab of cameras", lambda: Cameras(browser, hands, address, mirror)
            )
            self._placed("the floating views", lambda: FloatingViews(browser, hands, address, mirror))
        with tabs.add_tab("Signals"):
            self._placed("the tab of signals", lambda: Signals(gui, hands, mirror))
        with tabs.add_tab("Dialogs"):
            self._placed("the list of scripts", lambda: Scripts(gui))
            self._placed("the tab of dialogs", lambda: Interface(gui, hands))
        with tabs.add_tab("Clients"):
            self._placed("the tab of clients", lambda: Clients(gui))
        with tabs.add_tab("View"):
            self._world = World(browser, hands, mirror, gizmo, addresses.open)
            self._placed("the keys of the page", lambda: Shortcuts(gui, hands, self._world))
            self._shots = Shots(gui, self._tell)

    def _placed(self, name: str, make: Callable[[], P]) -> P:
        """Make a panel in the container that is open now, below the mark of its failures."""
        guard = Guarded(self._browser.gui, name)
        panel = make()
        self._parts.append((guard, panel))
        return panel

    def run(self) -> None:
        """Keep the viewer up to date until `end`."""
        next_survey = 0.0
        is_away = False
        shown: int | None = None
        while not self._ending.is_set():
            began = time.monotonic()
            pause = LOOKS
            is_seen = bool(self._browser.get_clients())
            if not is_seen:
                pause = UNSEEN
                renumber(self._browser)
            try:
                self._keep_past(is_seen)
                step = self._slider.step
                is_due = began >= next_survey
                # A past step changes only when the user turns to another one; the selection may change as well.
                if step is None or step != shown or is_due:
                    look = self._look(step)
                    shown = step
                    if not self._view.update(partial(self._follow, look)):
                        self._eye.forget_look()  # otherwise it would miss the content of this one
                        pause = AGAIN
                    if is_due:
                        next_survey = began + max(SURVEYS, pause)
                        if not self._survey(look):
                            self._eye.forget_survey()
                            next_survey = began + AGAIN
                is_away = False
            except Away as reason:
                if not is_away:
                    logger.warning("%s; the page tries again every second", reason)
                is_away, self._is_kept = True, False
                self._slider.leave()
                self._run.away(str(reason), is_busy=reason.is_busy)
                pause = AGAIN
            self._browser.flush()
            self._ending.wait(max(0.0, began + pause - time.monotonic()))

    def _keep_past(self, is_seen: bool) -> None:
        """Have the server keep the past while a browser is connected. Raises Away."""
        if is_seen != self._is_kept:
            self._eye.keep_past(is_seen)
            self._is_kept = is_seen

    def _look(self, step: int | None) -> Look:
        """Read the present, or a past step. Raises Away."""
        past = None if step is None else self._eye.past(step)
        if step is not None:
            self._slider.show(step, None if past is None else past["step"])
        self._mirror.is_past = past is not None
        return self._eye.look() if past is None else past["look"]

    def _follow(self, look: Look) -> None:
        if (title := f"{look['scene']} - simx") != self._title:
            self._title = title
            set_title(self._browser, title)
        self._world.update(look)
        self._cameras.follow()

    def _survey(self, look: Look) -> bool:
        """Update the panels; return whether all updates succeeded. Raises Away."""
        survey = self._eye.survey()
        now = look
        if self._mirror.is_past:  # the panels show the present beside it
            state, seconds, steps = survey["past"]["now"]
            now: Look = {**look, "running": state, "time": seconds, "steps": steps}
        sensing = self._eye.sensing() if self._world.wants_sensing else None
        if self._teleoperation is not None:
            arms = self._eye.arms(self._teleoperation.arm)
            self._teleoperation.show(arms, is_past=self._mirror.is_past)
        done = [
            self._surveyed.update(partial(self._world.survey, survey)),
            self._sensed.update(partial(self._world.sense, sensing)),
        ]
        done += [guard.update(partial(panel.update, survey, now)) for guard, panel in self._parts]
        return all(done)

    def end(self) -> None:
        """Make `run` return. Any thread."""
        self._ending.set()

    def close(self) -> None:
        self._shots.close()
        for _, panel in self._parts:
            panel.close()
        self._hands.close()
        self._eye.close()

    def _tell(self, problem: str) -> None:
        """Report in every browser for a while that a click could not be executed."""
        logger.warning("%s", problem)
        self._report("This was not done", problem, is_problem=True)

    def _report(self, title: str, text: str, *, is_problem: bool = False) -> None:
        for client in self._browser.get_clients().values():
            client.add_notification(title, text, color="red" if is_problem else "blue", auto_close_seconds=10)
