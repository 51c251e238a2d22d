"""Give still shapes other parents in a model that is compiled later; see `waiting.py`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from simx_server.scene.editing.recompile import refuse_in_physics
from simx_server.scene.editing.welding import start_pose
from simx_server.scene.objects import SceneObject
from simx_server.scene.poses.placing import body_pose
from simx_server.scene.poses.poses import compose, inverse

from .templates import PREFIXES
from .waiting import Basis, Waiting

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_IN_BODIES = ("joint", "site", "camera", "light")
"""Kinds of elements that are numbered by their bodies."""


def move_shape(sim: LiveScene, handle: int, parent: int) -> bool:
    """Give an object another parent and leave it where it is; return False, having done nothing, if that cannot wait.

    Objects that are fixed to the world can wait, together with all below them, if their new parent is fixed too. Their
    poses are those before all edits that wait, so each of them moves once until the compile.

    Raises CommandError: within a physics step. UnknownHandle.
    """
    refuse_in_physics(sim)
    waiting = sim.waiting
    if not sim.scene.keeps_ids or (waiting is not None and not waiting.has_only_moves):
        return False
    basis = Basis.of(sim) if waiting is None else Basis(waiting.before, waiting.model, waiting.data)
    moved = [handle, *sim.scene.descendants(handle)]
    if waiting is not None and not waiting.moved_objects.isdisjoint((*moved, parent)):
        return False
    if not _is_still(basis, sim.scene.get(handle), moved, parent):
        return False
    old = basis.scene.objects[handle]
    target = 0 if parent == -1 else basis.scene.objects[parent].body
    if waiting is None:
        if target == basis.model.body_parentid[old.body]:
            return False  # the model stays as it is
        waiting = Waiting.of(sim)
    if target != basis.model.body_parentid[old.body]:
        local = compose(inverse(body_pose(basis, target)), start_pose(basis, old.body))
        _renumber(waiting, handle, parent)
        waiting.move(old.element_name, basis.model.body(target).name, local)
    scene = waiting.scene
    scene.objects[handle] = scene.objects[handle].renumbered(
        scene.objects[handle].id, scene.objects[handle].body
    )
    scene.override_parent(handle, parent)
    waiting.moved_objects.update(moved)
    sim.hold(waiting)
    return True


def _is_still(basis: Basis, item: SceneObject, moved: list[int], parent: int) -> bool:
    """Return whether an object and a new parent are bodies that are fixed to the world."""
    model, objects = basis.model, basis.scene.objects
    if any(each not in objects for each in moved) or (parent != -1 and parent not in objects):
        return False
    above, target = objects.get(item.parent), objects.get(parent)
    if item.element != "body" or any(each is not None and each.element != "body" for each in (above, target)):
        return False
    body = objects[item.handle].body
    end = _end_of(model.body_parentid, body)
    names = {model.body(each).name for each in range(body, end)}
    at = 0 if target is None else target.body
    return not (
        model.body_weldid[body] != 0
        or model.body_weldid[at] != 0
        or body <= at < end
        or (model.body_jntnum[body:end] > 0).any()
        or (model.body_mocapid[body:end] >= 0).any()
        or names & (basis.scene.welded_bodies | basis.scene.weightless_bodies | basis.scene.made_static)
        or any(objects[each].element == "tendon" or not body <= objects[each].body < end for each in moved)
    )


def _end_of(parents: np.ndarray, body: int) -> int:
    """Return the id behind a body and all below it. `parents`: of each body."""
    behind = np.flatnonzero(parents[body + 1 :] < body)
    return body + 1 + int(behind[0]) if len(behind) else len(parents)


def _renumber(waiting: Waiting, handle: int, parent: int) -> None:
    """Give all objects the ids that they have when a body comes last below another."""
    scene = waiting.scene
    if waiting.parents is None:
        waiting.parents = waiting.model.body_parentid.copy()
        waiting.bodies_of = {
            kind: getattr(waiting.model, f"{PREFIXES[kind]}_bodyid").copy() for kind in _IN_BODIES
        }
    parents = waiting.parents
    body, target = scene.objects[handle].body, 0 if parent == -1 else scene.objects[parent].body
    end, place = _end_of(parents, body), _end_of(parents, target)
    rest = np.delete(np.arange(len(parents)), slice(body, end))
    order = np.insert(rest, place if place <= body else place - (end - body), np.arange(body, end))
    rank = np.argsort(order)
    parents[body] = target
    waiting.parents = rank[parents[order]]
    ranks = {"body": rank}
    for kind, bodies in waiting.bodies_of.items():
        there = rank[bodies]
        sequence = np.argsort(there, kind="stable")
        waiting.bodies_of[kind] = there[sequence]
        ranks[kind] = np.argsort(sequence)
    numbers = {kind: each.tolist() for kind, each in ranks.items()}
    for each, item in scene.objects.items():
        index = numbers[item.element][item.id] if item.element in numbers else item.id
        at = numbers["body"][item.body]
        if (index, at) != (item.id, item.body):
            scene.objects[each] = item.renumbered(index, at)
    scene.owners = scene.owners[order]
    scene.reindex()
