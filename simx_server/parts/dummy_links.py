"""Links between dummies: pairs that physics holds together, and tips with their targets.

A file gives the first links by annotations (`simx:dummy`). A link of physics is an equality constraint between the
places of two dummies, which closes a chain, or lets a gripper hold an object.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco

from simx_server.errors import CommandError
from simx_server.scene.editing.recompile import edit
from simx_server.scene.link_constraints import EQUALITY, IK, PHYSICS, add_weld, site_name, site_of
from simx_server.scene.objects import ObjectKind
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.objects import SceneObject
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation


class DummyLinks(Part):
    """The links of all dummies. The stop undoes a run's changes."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._others: dict[int, int] = {}
        """Handle to the linked dummy, -1 for none, where a program changed the file's."""
        self._types: dict[int, int] = {}
        self._before_the_run: tuple[dict[int, int], dict[int, int]] = {}, {}

    def scene_changed(self) -> None:
        self._others, self._types = {}, {}

    def run_started(self) -> None:
        self._before_the_run = dict(self._others), dict(self._types)

    def run_stopped(self) -> None:
        self._others, self._types = self._before_the_run

    def remember(self) -> object:
        return dict(self._others), dict(self._types)

    def recall(self, memory: Any) -> None:
        others, types = memory
        self._others, self._types = dict(others), dict(types)

    def saving(self, saved: Saved) -> None:
        for handle in self._sim.scene.of_kind(ObjectKind.DUMMY):
            if handle in saved.names:
                other = saved.name(self.linked(handle))
                kind = self.type(handle)
                words = {PHYSICS: None, IK: "ik"}
                saved.put(handle, "dummy", linked=other, link=words.get(kind, str(kind)))

    def linked(self, handle: int) -> int:
        """Return the handle of the linked dummy, -1 for none. Raises UnknownHandle, WrongKind."""
        item = self._sim.scene.get_kind(handle, ObjectKind.DUMMY)
        if handle in self._others:
            other = self._others[handle]
        else:
            name = item.annotations.get("dummy", {}).get("linked")
            found = self._sim.scene.by_name(str(name)) if name is not None else None
            other = -1 if found is None else found
        return other if other in self._sim.scene.objects else -1

    def type(self, handle: int) -> int:
        """Return the type of a dummy's link, PHYSICS without a link. Raises UnknownHandle, WrongKind."""
        item = self._sim.scene.get_kind(handle, ObjectKind.DUMMY)
        word = str(item.annotations.get("dummy", {}).get("link", "physics"))
        by_file = {"physics": PHYSICS, "ik": IK}.get(word)
        return self._types.get(handle, int(word) if by_file is None else by_file)

    def link(self, handle: int, other: int) -> None:
        """Link a dummy to another one, or with -1 to none; both lose their present links.

        Raises UnknownHandle, WrongKind, CommandError: a dummy cannot be linked to itself.
        """
        if handle == other:
            name = self._sim.scene.get_kind(handle, ObjectKind.DUMMY).name
            raise CommandError(f"'{name}' cannot be linked to itself; give another dummy, or -1 for none")
        pair = [handle] if other == -1 else [handle, other]
        partners = [self.linked(each) for each in pair]
        for each, partner in zip(pair, partners, strict=True):
            self._release(each)
            self._others[each] = -1
            if partner != -1:
                self._others[partner] = -1
        if other != -1:
            self._others[handle], self._others[other] = other, handle
            self._types[other] = self.type(handle)
            self._hold(handle, other)
        self._sim.changed()

    def set_type(self, handle: int, link_type: int) -> None:
        """Set the type of a dummy's link, and of its partner's. Raises UnknownHandle, WrongKind."""
        other = self.linked(handle)
        self._release(handle)
        for each in (handle, other):
            if each != -1:
                self._types[each] = link_type
        if other != -1:
            self._hold(handle, other)
        self._sim.changed()

    def _release(self, handle: int) -> None:
        """End the constraints of a dummy."""
        item = self._sim.scene.objects[handle]
        for equality in self._equalities(item):
            self._sim.data.eq_active[equality] = 0

    def _hold(self, handle: int, other: int) -> None:
        """Have physics hold two dummies together, if it moves at least one of them."""
        if self.type(handle) != PHYSICS:
            return
        model, objects = self._sim.model, self._sim.scene.objects
        first, second = objects[handle], objects[other]
        weld = model.body_weldid
        if weld[first.body] == weld[second.body]:
            return
        shared = set(self._equalities(first)) & set(self._equalities(second))
        if shared:
            self._sim.data.eq_active[min(shared)] = 1
            return

        def surgery(spec: mujoco.MjSpec) -> None:
            names = [site_of(spec, each) for each in (first, second)]
            add_weld(spec, f"{EQUALITY}{names[0]}:{names[1]}", names[0], names[1])

        edit(self._sim, surgery, set())

    def _equalities(self, item: SceneObject) -> list[int]:
        """Return the ids of the constraints of a dummy."""
        model = self._sim.model
        site = item.id
        if item.element == "body":
            site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, site_name(item.element_name))
        return [
            equality
            for equality in range(model.neq)
            if model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE.value
            and site in (model.eq_obj1id[equality], model.eq_obj2id[equality])
            and EQUALITY in model.equality(equality).name
        ]
