"""Contacts between parts of one robot that touch or overlap in the file: they press only beyond that.

Joints hold such parts exactly where they are. V-REP's engines see no force between two faces that lie upon each
other. MuJoCo does: its friction asks sliding surfaces to part a little, joints do not let them, and the contact brakes
the robot. Where hulls stand in for meshes, the overlap is not even in the file. So these pairs get a margin below the
overlap. They still stop each other when a joint moves them further into each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Any, NamedTuple

import mujoco
import numpy as np

from simx_server.scene.assets.filing import points_and_faces
from simx_server.scene.naming.names import INTERNAL
from simx_server.scene.poses.poses import IDENTITY, Pose, compose

_TOUCHING = 1e-4
"""Distance in metres up to which two parts touch."""

_ROOM = 2e-4
"""Metres beyond the overlap from which on the parts press: what joints and solver leave open."""

_MOST_PARTS = 500
"""Most geoms of one robot that are measured, all against all."""

_MESH, _HEIGHT_FIELD = mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_HFIELD


class _Part(NamedTuple):
    """A geom that collides, with what tells whether another one of its robot may touch it."""

    geom: Any
    pose: Pose
    """In the world."""
    link: int
    """Number of the rigid link that it belongs to; 0: nothing moves it."""
    link_above: int


def ease_link_contacts(spec: mujoco.MjSpec) -> None:
    """Give pairs of parts of one robot that touch in the file's pose a margin below their overlap.

    Args:
        spec: complete, except for names of geoms.
    """
    number = 0
    for top in spec.worldbody.bodies:
        parts = list(_parts(top))
        if not 1 < len(parts) <= _MOST_PARTS:
            continue
        pairs = [(one, other) for one, other in combinations(parts, 2) if _may_touch(one, other)]
        for (one, other), distance in _near(spec, pairs):
            overlap = max(-distance, 0.0) + _ROOM
            # The gap lets MuJoCo measure from a distance of 0 on: it measures none below.
            pair = spec.add_pair(name=f"{INTERNAL}links:{number}", margin=-overlap, gap=overlap)
            pair.geomname1, pair.geomname2 = _named(one.geom), _named(other.geom)
            _mix(pair, one.geom, other.geom)
            number += 1


def _parts(top: Any) -> Iterator[_Part]:
    """Yield the geoms that collide of a body and those below it."""
    links = 0
    waiting: list[tuple[Any, Pose, int, int]] = [(top, IDENTITY, 0, 0)]
    while waiting:
        body, above, link, link_above = waiting.pop()
        pose = compose(above, (tuple(body.pos), tuple(body.quat)))
        if list(body.joints):
            links += 1
            link, link_above = links, link
        for geom in body.geoms:
            if (geom.contype or geom.conaffinity) and geom.type != _HEIGHT_FIELD:
                yield _Part(geom, compose(pose, (tuple(geom.pos), tuple(geom.quat))), link, link_above)
        waiting += [(child, pose, link, link_above) for child in body.bodies]


def _may_touch(one: _Part, other: _Part) -> bool:
    """Return whether MuJoCo lets two parts collide: by their bits, and neighbours only where one is static."""
    if one.link == other.link:
        return False
    is_neighbour = one.link_above == other.link or other.link_above == one.link
    if is_neighbour and one.link and other.link:
        return False
    return bool(one.geom.contype & other.geom.conaffinity or other.geom.contype & one.geom.conaffinity)


def _near(
    spec: mujoco.MjSpec, pairs: list[tuple[_Part, _Part]]
) -> Iterator[tuple[tuple[_Part, _Part], float]]:
    """Yield the pairs that touch or overlap, with their distance in metres, below 0 for an overlap."""
    if not pairs:
        return
    parts = list({id(part): part for pair in pairs for part in pair}.values())
    model = _model_of(spec, parts)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    number = {id(part): geom for geom, part in enumerate(parts)}
    reach = model.geom_rbound + _TOUCHING
    for pair in pairs:
        one, other = (number[id(part)] for part in pair)
        apart = math.dist(data.geom_xpos[one], data.geom_xpos[other])
        if apart <= reach[one] + reach[other]:
            distance = mujoco.mj_geomDistance(model, data, one, other, 2 * _TOUCHING, None)
            if distance < _TOUCHING:
                yield pair, distance


def _model_of(spec: mujoco.MjSpec, parts: list[_Part]) -> mujoco.MjModel:
    """Return a model of these geoms alone, each at its pose in the world, in this order."""
    alone: Any = mujoco.MjSpec()
    for number, part in enumerate(parts):
        geom, (position, turn) = part.geom, part.pose
        # A body for each: MuJoCo sorts the geoms of one body.
        body = alone.worldbody.add_body(pos=position, quat=turn)
        if geom.type == _MESH:
            mesh = alone.add_mesh(name=str(number), inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
            mesh.uservert = points_and_faces(spec, spec.mesh(geom.meshname))[0].ravel()
            body.add_geom(type=_MESH, meshname=mesh.name)
        else:
            body.add_geom(type=geom.type, size=list(geom.size))
    return alone.compile()


def _named(geom: Any) -> str:
    """Return the name of a geom, which gets one for the pair."""
    if not geom.name:
        geom.name = f"{INTERNAL}part:{geom.parent.name}.{list(geom.parent.geoms).index(geom)}"
    return geom.name


def _mix(pair: Any, one: Any, other: Any) -> None:
    """Give a pair the contact that MuJoCo computes for two geoms."""
    if one.priority != other.priority:
        one = other = max(one, other, key=lambda geom: geom.priority)
    pair.condim = max(one.condim, other.condim)
    sliding, torsion, rolling = np.maximum(one.friction, other.friction).tolist()
    pair.friction[:] = (sliding, sliding, torsion, rolling, rolling)
    pair.solref[:] = (np.asarray(one.solref) + other.solref) / 2
    pair.solimp[:] = (np.asarray(one.solimp) + other.solimp) / 2
