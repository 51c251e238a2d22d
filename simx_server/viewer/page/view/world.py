"""The scene in 3-D: each body as one mesh that moves, drawing objects, the selection, contact forces."""

from __future__ import annotations

import logging
from collections.abc import Callable

import mujoco
import numpy as np
import viser

from simx_server.viewer.messages import Look, SceneItem, Sensing, Survey
from simx_server.viewer.page.link import Hands, make
from simx_server.viewer.page.mirror import Copy, Mirror
from simx_server.viewer.page.tools.address import View
from simx_server.viewer.page.tools.gizmo import Gizmo
from simx_server.viewer.page.tools.sensors import FORCE_LENGTH, LONGEST_ARROW, Sensors
from simx_server.viewer.page.tools.viewpoints import Viewpoints

from .bodies import Body
from .drawings import Drawings
from .geoms import appearance, meshes_of
from .ground import is_ground
from .lights import Lights
from .selected import Selected

logger = logging.getLogger(__name__)

_MOVED = 1e-5
"""Metres, or a unit quaternion's difference, below which nothing is sent."""

_FORCE = (220, 40, 60)


class World:
    """Owns the 3-D view. `update` and `survey` on the viewer's thread."""

    def __init__(
        self,
        browser: viser.ViserServer,
        hands: Hands,
        mirror: Mirror,
        gizmo: Gizmo,
        open_address: Callable[[viser.ClientHandle], View | None],
    ) -> None:
        self._browser, self._hands, self._gizmo = browser, hands, gizmo
        self._mirror = mirror
        self._drawings = Drawings(browser.scene)
        self._marks = Selected(browser.scene)
        self._bodies: dict[int, Body] = {}
        self._looks: list[bytes] = []
        """By body, the appearance from which it was made."""

        self._places = np.empty((0, 7))
        """By body, its pose in the browsers: position and quat_wxyz."""

        self._tree: list[SceneItem] = []
        self._places_of: dict[int, tuple[str, int]] = {}
        """Handle to type and number of the model element."""

        self._selected: tuple[int, ...] = ()
        self._forces: viser.ArrowsHandle | None = None
        self._arrows = np.empty((0, 2, 3))
        """The content of `_forces`."""

        browser.scene.set_up_direction("+z")
        gui = browser.gui
        self._show_forces = gui.add_checkbox(
            "Contact forces", False, hint=f"{FORCE_LENGTH * 100:g} cm for each newton"
        )
        self._show_drawings = gui.add_checkbox("Drawing objects", True, hint="what scripts have drawn")
        self._lights = Lights(browser.scene, gui)
        self._sensors = Sensors(browser.scene, gui)
        self.viewpoints = Viewpoints(browser, open_address)
        self._extent = 2.0
        self._turns = 0
        """How often a script has chosen a camera for the window."""

    def update(self, look: Look) -> None:
        """Show a new look."""
        is_new, is_reshaped = self._mirror.update(look)
        copy = self._mirror.copy
        assert copy is not None
        with self._browser.atomic():
            if is_new:
                self._clear(copy.model)
            if is_new or is_reshaped:
                self._build(copy)
            self._move(copy.data)
            self._mark(look["selection"])
            self._marks.move(copy)
            self._show_contacts(copy)
        if is_new:
            self._lights.update(copy)  # its background
            self._extent = copy.extent
            self.viewpoints.show(copy.content)
        elif is_reshaped or self._lights.is_stale:
            self._lights.follow(copy)
        self.viewpoints.update(copy, self._places_of, look["selection"])
        self._gizmo.update(copy, self._places_of, look["selection"], is_past=self._mirror.is_past)

    @property
    def wants_sensing(self) -> bool:
        """Return whether readings of sensors are shown."""
        return self._sensors.are_wanted and not self._mirror.is_past

    def focus(self, client: viser.ClientHandle | None) -> None:
        """Look at the selected object in one browser; at the whole scene if none is selected."""
        copy = self._mirror.copy
        place = next((self._places_of[each] for each in self._selected if each in self._places_of), None)
        if copy is None or place is None:
            self.viewpoints.reset(client)
        else:
            self.viewpoints.focus(client, copy, *place)

    def toggle_shadows(self) -> None:
        """Switch shadows on or off, in all browsers."""
        self._lights.toggle_shadows()

    def spare_shadows(self) -> None:
        """Switch shadows off for a slow browser, unless a user has chosen."""
        self._lights.spare_shadows()

    def sense(self, sensing: Sensing | None) -> None:
        """Show readings of sensors; None: none."""
        self._sensors.update(sensing)

    def survey(self, survey: Survey) -> None:
        """Show the data that changes rarely."""
        if survey["tree"] is not None:
            self._tree = survey["tree"]
            self._places_of = {item["handle"]: (item["element"], item["id"]) for item in self._tree}
            self._mark(self._selected, anew=True)
        views = survey["interface"]["views"]
        self._gizmo.navigate(views["navigation"])
        if views["turns"] != self._turns and self._mirror.copy is not None:
            self._turns = views["turns"]
            element, number = self._places_of.get(views["camera"], ("", -1))
            if element == "camera":
                self.viewpoints.look_from_camera(self._mirror.copy, number)
        if survey["drawings"] is not None:
            self._drawings.update(survey["drawings"])
        self._drawings.frame.visible = self._show_drawings.value

    # --- bodies ----------------------------------------------------------------------------------

    def _clear(self, model: mujoco.MjModel) -> None:
        for body in self._bodies.values():
            body.remove()
        self._bodies.clear()
        self._looks = [b""] * model.nbody

    def _build(self, copy: Copy) -> None:
        """Make the bodies that look different from before."""
        model = copy.model
        for number in range(model.nbody):
            look = appearance(model, number)
            if look == self._looks[number]:
                continue
            self._looks[number] = look
            if before := self._bodies.pop(number, None):
                before.remove()
            try:
                meshes = list(meshes_of(model, number))
            except Exception:  # from the converter, with a scene that was never tried
                logger.exception("body '%s' cannot be drawn; the others are", model.body(number).name)
                continue
            if meshes:
                body = Body(self._browser.scene, number, meshes, is_ground=is_ground(copy, number))
                body.on_click(self._clicked)
                self._bodies[number] = body
        self._places = np.full((model.nbody, 7), np.nan)
        self._mark(self._selected, anew=True)

    def _move(self, data: mujoco.MjData) -> None:
        """Send the poses of bodies that have moved."""
        places = np.concatenate([data.xpos, data.xquat], axis=1)
        moved = ~np.all(np.abs(places - self._places) <= _MOVED, axis=1)
        for number in np.flatnonzero(moved).tolist():
            if body := self._bodies.get(number):
                body.move(places[number, :3], places[number, 3:])
        self._places[moved] = places[moved]

    def _clicked(self, number: int) -> None:
        """Select the object of a clicked body. A click on the ground clears the selection."""
        assert self._mirror.copy is not None
        if is_ground(self._mirror.copy, number):
            number = 0
        handles = {item["id"]: item["handle"] for item in self._tree if item["element"] == "body"}
        parents = self._mirror.copy.model.body_parentid
        while number and number not in handles:
            number = int(parents[number])
        chosen = [handles[number]] if number in handles else []
        self._hands.do(lambda client: make(client, lambda calls: calls.simxSetObjectSelection(chosen)))

    def _mark(self, selection: list[int] | tuple[int, ...], *, anew: bool = False) -> None:
        if tuple(selection) == self._selected and not anew:
            return
        self._selected = tuple(selection)
        items = [item for item in self._tree if item["handle"] in self._selected]
        self._marks.choose(items, self._extent)
        ids = {item["id"] for item in items if item["element"] == "body"}
        for number, body in self._bodies.items():
            body.mark(number in ids)

    # --- contacts --------------------------------------------------------------------------------

    def _show_contacts(self, copy: Copy) -> None:
        arrows = contact_forces(copy) if self._show_forces.value else np.empty((0, 2, 3))
        if np.array_equal(arrows, self._arrows):
            return
        self._arrows = arrows
        if self._forces is not None:
            self._forces.remove()
            self._forces = None
        if len(arrows):
            self._forces = self._browser.scene.add_arrows(
                "/contact_forces", arrows, _FORCE, shaft_radius=0.004, head_radius=0.01, head_length=0.02
            )


def contact_forces(copy: Copy) -> np.ndarray:
    """Return arrows of contact forces, in newtons as metres, shape (N, 2, 3): start and end in the world."""
    model, data = copy.model, copy.data
    mujoco.mj_forward(model, data)
    arrows: list[np.ndarray] = []
    force = np.zeros(6)
    for number in range(data.ncon):
        mujoco.mj_contactForce(model, data, number, force)
        contact = data.contact[number]
        arrow = contact.frame.reshape(3, 3).T @ force[:3] * FORCE_LENGTH
        if (length := float(np.linalg.norm(arrow))) > 1e-4:
            arrow *= min(1.0, LONGEST_ARROW / length)
            arrows.append(np.stack([contact.pos, contact.pos + arrow]))
    return np.array(arrows).reshape(-1, 2, 3)
