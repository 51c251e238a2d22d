"""V-REP's object settings without a place in MuJoCo: visibility layers, first velocity, respondable mask."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from simx_client.protocol import constants as c
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene import properties
from simx_server.scene.cameras.visibility import VISIBLE_GROUPS
from simx_server.scene.colliding.mask_bits import ALL_MASKS
from simx_server.scene.colliding.respondable import governed_shapes, needs_exclusions, set_masks
from simx_server.scene.editing import renaming
from simx_server.scene.formats.annotations import Annotations, numbers_of
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.placing import body_pose, free_joint
from simx_server.scene.poses.poses import conjugate, rotate
from simx_server.scene.properties import FIRST_LAYER, SHOWN_LAYERS
from simx_server.scene.saved import numbers_text
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.copies.kept import Kept
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation
    from simx_server.simulation.surfaces import Surfaces

_LAYERS = 0xFFFF
_HIDDEN = 0x0100
"""V-REP's ninth layer, where its models keep hidden parts."""

_STILL = (0.0,) * 6


class DrawnSize(IntEnum):
    """Sizes in metres with which V-REP's window draws objects that have no surface: numbers of kept parameters, beyond
    those of the original's.
    """

    SENSOR = 90_003
    SENSOR_POINT = 90_004


@dataclass(frozen=True)
class _Settings:
    """The settings of one object."""

    layers: int | None = None
    """Visibility layers; None: not set yet."""
    first_velocity: tuple[float, ...] = _STILL
    mask: int = ALL_MASKS


class ObjectSettings(Part):
    """The settings of all objects of the scene, by handle. The stop undoes a run's changes."""

    def __init__(self, sim: Simulation, surfaces: Surfaces) -> None:
        self._sim, self._surfaces = sim, surfaces
        self._known: dict[int, _Settings] = {}
        self._before_the_run: dict[int, _Settings] = {}
        self._kept: dict[tuple[int, int], float] = {}
        """Values of parameters without effect, by object and number."""
        self._kept_before_the_run: dict[tuple[int, int], float] = {}
        self._placed: set[int] = set()
        """Handles of objects that were placed since the last physics."""
        self.has_work = False
        """Whether objects were ever placed."""
        self._launched: tuple[Annotations | None, int, frozenset[int]] = None, -1, frozenset()
        """Annotations, version of the tree, and the objects with a first velocity by them."""

    def scene_changed(self) -> None:
        self._known = {}
        self._kept = {}

    def run_started(self) -> None:
        self._begin_run()

    def run_stopped(self) -> None:
        self._end_run()

    def remember(self) -> object:
        return dict(self._known), frozenset(self._placed), dict(self._kept)

    def recall(self, memory: Any) -> None:
        known, placed, kept = memory
        self._known, self._kept = dict(known), dict(kept)
        self._placed.clear()
        self._place(placed)

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        self._known |= {copies[handle]: known for handle, known in self._known.items() if handle in copies}
        self._kept |= {
            (copies[handle], number): value
            for (handle, number), value in self._kept.items()
            if handle in copies
        }
        self.apply_masks()

    def object_scaled(self, handle: int, factor: float) -> None:
        for size in DrawnSize:
            if (handle, size) in self._kept:
                self._kept[handle, size] *= factor

    def saving(self, saved: Saved) -> None:
        for handle, known in self._known.items():
            if handle in saved.names:
                saved.put(handle, "object", layers=known.layers)
                if self._sim.scene.objects[handle].kind == ObjectKind.SHAPE:
                    velocity = numbers_text(known.first_velocity) if known.first_velocity != _STILL else None
                    key = "mask" if "mask" in saved.objects[handle].get("shape", {}) else "pair_mask"
                    mask = known.mask if known.mask != ALL_MASKS or key == "mask" else None
                    saved.put(handle, "shape", first_velocity=velocity, **{key: mask})
        for (handle, number), value in self._kept.items():
            if handle in saved.names:
                saved.put(handle, "kept", **{str(number): repr(float(value))})

    @property
    def visible_layers(self) -> int:
        """Return `sim_intparam_visible_layers`: the layers that the views of users show."""
        return int(self._sim.scene.annotations.scene.get("layers", SHOWN_LAYERS))

    @visible_layers.setter
    def visible_layers(self, layers: int) -> None:
        scene = self._sim.scene
        notes = {**scene.annotations.scene, "layers": layers & _LAYERS}
        scene.annotations = replace(scene.annotations, scene=notes)
        properties.apply(self._sim)
        self._sim.changed()

    def kept(self, handle: int, number: int, default: float) -> float:
        """Return the value of an object's parameter that has no effect here."""
        known = self._kept.get((handle, number))
        if known is None:
            item = self._sim.scene.objects.get(handle)
            note = item.annotations.get("kept", {}) if item is not None else {}
            known = float(note.get(str(number), default))
        return known

    def keep(self, handle: int, number: int, value: float) -> None:
        """Store the value of an object's parameter that has no effect here."""
        self._kept[handle, number] = value

    def layers(self, handle: int) -> int:
        """Return the visibility layers, 16 bits. Cameras show an object when one of them is among the visible layers.

        Vision sensors see an object on any layer, as in V-REP. The default is the first layer, or, for a shape that
        images do not show, the ninth. Raises UnknownHandle.
        """
        self._sim.scene.get(handle)
        layers = self._of(handle).layers
        return layers if layers is not None else (FIRST_LAYER if self.is_drawn(handle) else _HIDDEN)

    def set_layers(self, handle: int, layers: int) -> None:
        """Set the visibility layers. Raises UnknownHandle, CommandError: more than 16 bits."""
        self._sim.scene.get(handle)
        if not 0 <= layers <= _LAYERS:
            raise CommandError(f"visibility layers are 16 bits, 0 to {_LAYERS}, not {layers}")
        self._set(handle, layers=layers)
        if self._sim.scene.objects[handle].kind == ObjectKind.SHAPE:  # views show others by their layers, too
            renaming.annotate(self._sim, handle, "object", {"layers": layers})
            properties.apply(self._sim)

    def is_visible(self, handle: int) -> bool:
        """Return whether cameras show the object: neither its layers nor its models hide it. Raises UnknownHandle."""
        by_layer = self.layers(handle) & self.visible_layers
        return bool(by_layer) and not self._sim.scene.overridden(handle) & c.sim_modelproperty_not_visible

    def first_velocity(self, handle: int) -> tuple[float, ...]:
        """Return the first velocity: linear m/s and angular rad/s, 6 numbers, world axes; zero once it was applied.

        Raises UnknownHandle, WrongKind.
        """
        self._sim.scene.get_kind(handle, ObjectKind.SHAPE)
        return self._of(handle).first_velocity

    def set_first_velocity(self, handle: int, index: int, value: float) -> None:
        """Set one of the six numbers of the first velocity.

        The shape gets the velocity when the simulation starts. In a running simulation it gets the velocity when it is
        placed next, which is when V-REP adds it to the physics again. A static shape stays where it is, but its surface
        has the velocity, as that of a conveyor belt, until it is placed with another one.

        Raises UnknownHandle, WrongKind, CommandError: a link or a part of the world cannot move freely.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.SHAPE)
        model = self._sim.model
        if item.element != "body" or (model.body_jntnum[item.body] and free_joint(model, item.body) < 0):
            raise CommandError(
                f"'{item.name}' is a part of a mechanism or of the world; only a single body has a velocity of its own"
            )
        values = list(self._of(handle).first_velocity)
        values[index] = value
        self._set(handle, first_velocity=tuple(values))

    def launch(self, handles: Collection[int]) -> None:
        """Apply the pending first velocities of placed shapes; velocities that are set before physics count too."""
        self._place(handles)
        self._launch_free(handles)

    def _place(self, handles: Collection[int]) -> None:
        self._placed.update(handles)
        if self._placed and not self.has_work:
            self.has_work = True
            self._sim.parts.replan()

    def launch_placed(self) -> None:
        """Apply the first velocities of the shapes that were placed since the last physics."""
        if not self._placed:
            return
        self._launch_free(self._placed)
        model, objects = self._sim.model, self._sim.scene.objects
        for handle in self._placed:
            item = objects.get(handle)
            is_shape = item is not None and item.kind == ObjectKind.SHAPE and item.element == "body"
            if item is not None and is_shape and model.body_weldid[item.body] == 0:
                self._surfaces.drive(handle, self._of(handle).first_velocity)
        self._placed.clear()

    def _launch_free(self, handles: Collection[int]) -> None:
        model, data = self._sim.model, self._sim.data
        in_file = self._launched_by_file()
        if not self._known and not in_file:
            return
        for handle in handles:
            if handle not in self._known and handle not in in_file:
                continue
            velocity = self._of(handle).first_velocity
            item = self._sim.scene.objects.get(handle)
            if velocity == _STILL or item is None or (joint := free_joint(model, item.body)) < 0:
                continue
            self._sim.refresh()
            turn = conjugate(body_pose(self._sim, item.body)[1])
            dof = int(model.jnt_dofadr[joint])
            data.qvel[dof : dof + 3] = velocity[:3]
            # MuJoCo's free joint has its angular velocity in the body's frame.
            data.qvel[dof + 3 : dof + 6] = rotate(turn, velocity[3:])
            self._set(handle, first_velocity=_STILL)
            self._sim.changed()

    def _launched_by_file(self) -> Collection[int]:
        """Return the objects that the scene's annotations give a first velocity."""
        scene = self._sim.scene
        annotations, version, found = self._launched
        if annotations is not scene.annotations or version != scene.properties_version:
            found = frozenset(self._annotated("shape", "first_velocity"))
            self._launched = scene.annotations, scene.properties_version, found
        return found

    def mask(self, handle: int) -> int:
        """Return the respondable mask, 16 bits. Raises UnknownHandle, WrongKind."""
        self._sim.scene.get_kind(handle, ObjectKind.SHAPE)
        return self._of(handle).mask

    def set_mask(self, handle: int, mask: int) -> None:
        """Set the respondable mask.

        Raises UnknownHandle, WrongKind, CommandError: more than 16 bits; a part of the world.
        """
        if not 0 <= mask <= ALL_MASKS:
            raise CommandError(f"a respondable mask is 16 bits, 0 to {ALL_MASKS}, not {mask}")
        set_masks(self._sim, self._masks() | {handle: mask})
        self._set(handle, mask=mask)

    def apply_masks(self) -> None:
        """Apply all masks again: after a change of the tree the other byte of a mask may count.

        Call it as well after a shape has become static or dynamic, respondable or not.
        """
        if self._sim.waiting is not None:
            self._sim.waiting.afterwards[self.apply_masks] = None
            return
        masks = self._masks()
        if masks or governed_shapes(self._sim):
            set_masks(self._sim, masks)

    @property
    def masks_keep_bodies_apart(self) -> bool:
        """Return whether `apply_masks` may make an edit: bits alone do not say what may collide."""
        masks, governed = self._masks(), {item.handle for item in governed_shapes(self._sim)}
        return not masks.keys() <= governed or (bool(governed) and needs_exclusions(self._sim.model))

    def _masks(self) -> dict[int, int]:
        annotated = {*self._annotated("shape", "mask"), *self._annotated("shape", "pair_mask")}
        objects = self._sim.scene.objects
        masks = {
            handle: self._of(handle).mask for handle in self._known.keys() | annotated if handle in objects
        }
        return {handle: mask for handle, mask in masks.items() if mask != ALL_MASKS}

    def _annotated(self, kind: str, key: str) -> list[int]:
        """Return the handles of the objects whose annotation has a key; few of many objects have annotations."""
        scene = self._sim.scene
        names = [name for name, notes in scene.annotations.objects.items() if key in notes.get(kind, {})]
        return [handle for handle in map(scene.by_name, names) if handle is not None]

    def _begin_run(self) -> None:
        self._before_the_run = dict(self._known)
        self._kept_before_the_run = dict(self._kept)
        self.launch({*self._known, *self._launched_by_file()})

    def _end_run(self) -> None:
        self._placed.clear()
        self._known = self._before_the_run
        self._kept = self._kept_before_the_run

    def _of(self, handle: int) -> _Settings:
        known = self._known.get(handle)
        return known if known is not None else self._in_file(handle)

    def _in_file(self, handle: int) -> _Settings:
        """Return the settings that annotations give to an object."""
        item = self._sim.scene.objects.get(handle)
        if item is None or not item.annotations:
            return _Settings()
        note, shape = item.annotations.get("object", {}), item.annotations.get("shape", {})
        return _Settings(
            layers=int(note["layers"]) if "layers" in note else None,
            first_velocity=numbers_of(shape["first_velocity"]) if "first_velocity" in shape else _STILL,
            mask=int(shape.get("mask", shape.get("pair_mask", ALL_MASKS))),
        )

    def _set(self, handle: int, **values: Any) -> None:
        self._known[handle] = replace(self._of(handle), **values)

    def is_drawn(self, handle: int) -> bool:
        """Return whether images show a shape, by its own geom groups, regardless of models; True for other objects.

        Raises UnknownHandle.
        """
        item = self._sim.scene.get(handle)
        if item.kind != ObjectKind.SHAPE:
            return True
        if self._sim.waiting is not None and handle in self._sim.waiting.plain:
            return True  # nothing has hidden a new shape yet
        model, scene = self._sim.model, self._sim.scene
        return any(
            scene.withheld.get((model.geom(geom).name, "geom_group"), model.geom_group[geom])
            in VISIBLE_GROUPS
            for geom in range(model.ngeom)
            if scene.owner_of_geom(geom, model) == item.handle
        )
