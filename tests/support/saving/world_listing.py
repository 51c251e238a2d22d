"""Everything that programs can read of a world, as plain values by name: to compare two worlds."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np
import pytest

from simx_server.editing import object_flags
from simx_server.errors import CommandError
from simx_server.handlers.objects import bounding_box
from simx_server.handlers.quantities.engine import ENGINE
from simx_server.handlers.quantities.objects import entries_of
from simx_server.parts.custom_data import HIDDEN, REFERENCES, SCENE
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.placing import moving_pose, object_pose
from simx_server.sim_api.properties.property_types import HANDLE, HANDLE_ARRAY
from simx_server.sim_api.properties.table import of_kind, of_target
from simx_server.world.world import World

Quantities = dict[str, Any]

_NOT_COMPARED = {
    *("handle", "objectUid", "parentUid", "persistentUid", "dna", "detachedScript", "meshes"),
    *("selected", "selectionHandles", "objectHandles", "orphanHandles", "scenePath", "sceneUid"),
    *("calcRotationAxis", "detectedObject", "depthBuffer", "imageBuffer", "packedDepthBuffer"),
    *("vertices", "indices", "normals"),
}
"""Properties that belong to a session, or to a measurement, or follow from the geoms, which `_geom` compares."""

_OF_HANDLES = ("entity", "link_dummy", "dependency_id", "handle")
"""Parts of the names of parameters whose values are handles."""

_FEW = 16
"""Numbers that are compared faster one by one than as an array."""

_OPTIONS = ("gravity", "wind", "density", "viscosity", "impratio", "iterations", "integrator", "timestep")
_CONSTANTS = (
    *("qpos0", "body_mass", "body_inertia", "dof_M0", "dof_armature", "dof_damping", "eq_data"),
    *("actuator_gainprm", "actuator_biasprm"),
)


def listing(world: World) -> dict[str, Quantities]:
    """Every readable quantity by object and name; handles are names."""
    sim = world.simulation
    sim.refresh()
    with _computed_once():
        found = {item.name: _of_object(world, handle) for handle, item in sim.scene.objects.items()}
        found["the scene"] = _of_scene(world)
    return found


@contextmanager
def _computed_once() -> Iterator[None]:
    """Compute each box once: each of its numbers is one quantity."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bounding_box, "of_object", _remembering(bounding_box.of_object))
        patch.setattr(bounding_box, "own_box", _remembering_boxes(bounding_box.own_box))
        yield


def _remembering(compute: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of a world that stays as it is, a handle and options which computes each result once."""
    known: dict[Any, Any] = {}

    def get(world: World, handle: int, **options: bool) -> Any:
        key = (handle, *sorted(options.items()))
        if key not in known:
            known[key] = compute(world, handle, **options)
        return known[key]

    return get


def _remembering_boxes(compute: Callable[..., Any]) -> Callable[..., Any]:
    """Return the same for the box of an object alone, of which the boxes of all models around it consist."""
    known: dict[Any, Any] = {}

    def get(world: World, instant: Any, item: SceneObject, *, with_volumes: bool) -> Any:
        key = (item.handle, with_volumes)
        if key not in known:
            known[key] = compute(world, instant, item, with_volumes=with_volumes)
        return known[key]

    return get


def differences(
    before: Mapping[str, Quantities], after: Mapping[str, Quantities], *, tolerance: float = 1e-9
) -> list[str]:
    """One line for each quantity that differs; numbers by more than the tolerance, relative and absolute."""
    lines = [
        f"{name}: only {'before' if name in before else 'after'}" for name in before.keys() ^ after.keys()
    ]
    for name in before.keys() & after.keys():
        first, second = before[name], after[name]
        lines += [
            f"{name}.{key}: {str(first.get(key))[:90]} -> {str(second.get(key))[:90]}"
            for key in first.keys() | second.keys()
            if not _are_equal(first.get(key), second.get(key), tolerance)
        ]
    return sorted(lines)


def _are_equal(one: Any, other: Any, tolerance: float) -> bool:
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        near = max(tolerance, 1e-6)
        return one.shape == other.shape and bool(np.allclose(one, other, rtol=near, atol=near))
    if isinstance(one, float) and isinstance(other, (float, int)):
        is_close = math.isclose(one, other, rel_tol=tolerance, abs_tol=tolerance)
        return is_close or (math.isnan(one) and math.isnan(other))
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        if len(one) != len(other):
            return False
        kinds = {*map(type, one), *map(type, other)} if len(one) > _FEW else set()
        if kinds == {int}:
            return list(one) == list(other)
        if kinds == {float}:
            return list(one) == list(other) or np.allclose(
                one, other, rtol=tolerance, atol=tolerance, equal_nan=True
            )
        return all(_are_equal(*pair, tolerance) for pair in zip(one, other, strict=True))
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_are_equal(one[key], other[key], tolerance) for key in one)
    return type(one) is not np.ndarray and bool(one == other)


def _value(world: World, get: Callable[[World, int], Any], handle: int) -> Any:
    try:
        return get(world, handle)
    except CommandError as problem:
        return f"error: {type(problem).__name__}"


def _name(world: World, handle: Any) -> Any:
    item = world.simulation.scene.objects.get(handle)
    if item is None and handle in world.collections:
        return world.collections.name(handle)
    return handle if item is None else item.name


def _of_object(world: World, handle: int) -> Quantities:
    sim = world.simulation
    item = sim.scene.objects[handle]
    return {
        "kind": item.kind,
        "parent": _name(world, item.parent),
        "alias": item.alias,
        "pose": object_pose(sim, item),
        "moving pose": moving_pose(sim, item),
        "flags": (object_flags.flags(world, handle), object_flags.special_flags(world, handle)),
        "model": sim.scene.model_property(handle),
        **_properties(world, handle, item.kind),
        **_parameters(world, handle, item.kind),
        **_data(world, handle),
        **_OF_KIND.get(item.kind, lambda _world, _handle: {})(world, handle),
    }


def _properties(world: World, handle: int, kind: ObjectKind) -> Quantities:
    found: Quantities = {}
    for name, entry in of_kind(kind).items():
        if entry.get is None or name in _NOT_COMPARED:
            continue
        value = _value(world, entry.get, handle)
        if entry.type is HANDLE or name.endswith("Handle"):
            value = _name(world, value)
        elif entry.type is HANDLE_ARRAY and isinstance(value, list):
            value = [_name(world, each) for each in value]
        found[f"property {name}"] = value
    return found


def _parameters(world: World, handle: int, kind: ObjectKind) -> Quantities:
    found: Quantities = {}
    for each in entries_of(kind).values():
        if each.get is not None:
            value = _value(world, each.get, handle)
            is_handle = any(word in each.name for word in _OF_HANDLES)
            found[f"parameter {each.name}"] = _name(world, value) if is_handle else value
    return found


def _data(world: World, handle: int) -> Quantities:
    data, parameters = world.custom_data, world.script_parameters
    blocks = {name: data.read(handle, name) or b"" for name in data.names(handle)}
    made = {name for owner, name in parameters._set if owner == handle}
    noted = world.simulation.scene.objects[handle].annotations.get("parameters", {})
    return {
        "data": {name: content for name, content in blocks.items() if not name.startswith(REFERENCES)},
        "references": {
            name.removeprefix(HIDDEN): [_name(world, each) for each in np.frombuffer(content, "<i4").tolist()]
            for name, content in blocks.items()
            if name.startswith(REFERENCES)
        },
        "user parameters": {name: parameters.get(handle, name) for name in {*noted, *made}},
    }


def _of_shape(world: World, handle: int) -> Quantities:
    settings, colors = world.object_settings, world.shape_colors
    numbers = [each for number, each in ENGINE.items() if "body" in each.name and number >= 6000]
    return {
        **{each.name: _value(world, each.get, handle) for each in numbers if each.get is not None},
        "geoms": _geoms(world, handle),
        "colours": [colors.get_each(handle, component) for component in range(6)],
        "mask": settings.mask(handle),
        "first velocity": settings.first_velocity(handle),
    }


def _geoms(world: World, handle: int) -> list[Any]:
    model = world.simulation.model
    own = world.instants.now(with_points=False).surroundings.owned_by([handle])
    return [_geom(model, geom) for geom in np.flatnonzero(own).tolist()]


def _geom(model: mujoco.MjModel, geom: int) -> list[Any]:
    row: list[Any] = [getattr(model, f"geom_{name}")[geom].item() for name in ("type", "group")]
    row += [getattr(model, f"geom_{name}")[geom].tolist() for name in ("size", "pos", "quat", "friction")]
    row += [int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])]
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.mesh(int(model.geom_dataid[geom]))
        start = int(mesh.vertadr[0])
        row.append(model.mesh_vert[start : start + int(mesh.vertnum[0])].astype(float))
        start = int(mesh.faceadr[0])
        row.append(model.mesh_face[start : start + int(mesh.facenum[0])])
    elif model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_HFIELD:
        field = model.hfield(int(model.geom_dataid[geom]))
        row += [field.size.tolist(), field.nrow.item(), field.data.astype(float)]
    material = int(model.geom_matid[geom])
    if material >= 0:
        row += [model.mat_rgba[material].tolist(), float(model.mat_specular[material])]
        texture = int(model.mat_texid[material, 1])
        if texture >= 0:
            size = int(model.tex_width[texture] * model.tex_height[texture] * model.tex_nchannel[texture])
            start = int(model.tex_adr[texture])
            row.append(model.tex_data[start : start + size].astype(float))
    return row


def _of_path(world: World, handle: int) -> Quantities:
    track = world.paths.get(handle)
    return {
        "points": [list(vars(each).values()) for each in track.curve.control],
        "rules": str(track.curve.rules),
        "along": (track.position, track.target_velocity, track.acceleration, track.is_explicit),
    }


def _of_dummy(world: World, handle: int) -> Quantities:
    return {"follower": world.paths.follower(handle), **_of_graph(world, handle)}


def _of_graph(world: World, handle: int) -> Quantities:
    if handle not in world.graphs.handles():
        return {}
    graph = world.graphs.get(handle)
    streams = [(each.name, each.color) for each in graph.streams.values() if each.lasts]
    return {"streams": streams, "explicit": graph.is_explicit}


def _of_cloud(world: World, handle: int) -> Quantities:
    return {"points": world.clouds.places(handle), "settings": world.clouds.settings(handle)}


_OF_KIND: Mapping[ObjectKind, Callable[[World, int], Quantities]] = {
    ObjectKind.SHAPE: _of_shape,
    ObjectKind.PATH: _of_path,
    ObjectKind.DUMMY: _of_dummy,
    ObjectKind.GRAPH: _of_graph,
    ObjectKind.POINT_CLOUD: _of_cloud,
    ObjectKind.OCTREE: _of_cloud,
}


def _of_scene(world: World) -> Quantities:
    sim, collections, data = world.simulation, world.collections, world.custom_data
    model = sim.model
    found: Quantities = {"objects": [item.name for item in sim.scene.objects.values()]}
    for name, entry in of_target(SCENE).items():
        if entry.get is not None and name not in _NOT_COMPARED and entry.type not in (HANDLE, HANDLE_ARRAY):
            found[f"property {name}"] = _value(world, entry.get, SCENE)
    meters = world.meters
    found |= {
        "times": (sim.time_step, sim.physics_step),
        "switches": (
            *(sim.dynamics_enabled, meters.collisions.enabled, meters.distances.enabled),
            *(world.proximity.enabled, world.vision.enabled, world.paths.is_enabled),
        ),
        "view": (world.object_settings.visible_layers, list(world.vision.background)),
        "options": [np.array(getattr(model.opt, name), float) for name in _OPTIONS],
        "collections": {
            name: (
                [_name(world, each) for each in collections.members(handle)],
                collections.overrides(handle),
            )
            for handle, name in collections._all().items()
        },
        "groups": {group.name: _group(world, group) for group in world.ik_groups.all().values()},
        "registered": {
            kind: sorted(names)
            for kind, names in sim.parts.registered_names().items()
            if kind not in ("collection", "ik")  # scripts make them without registering them
        },
        "scripts": sorted(_script(world, script) for script in world.scripts.all()),
        "data": {name: data.read(SCENE, name) for name in data.names(SCENE)},
        "counts": (model.nbody, model.njnt, model.neq, model.nu, model.ngeom, model.nsensor),
        "equalities": sim.data.eq_active.tolist(),
        "constants": {name: np.array(getattr(model, name), float) for name in _CONSTANTS},
    }
    return found


def _group(world: World, group: Any) -> list[Any]:
    elements = [
        (
            *[_name(world, each) for each in (one.tip, one.target, one.base, one.axes)],
            *(one.constraints, one.precision, one.weights, one.enabled),
        )
        for one in group.elements
    ]
    return [
        *(elements, group.how, group.explicit, group.enabled, group.restore, group.after),
        *(group.ignores_steps, group.margins),
    ]


def _script(world: World, script: Any) -> tuple[Any, ...]:
    text = script.source(world.simulation).decode("utf-8", "replace").strip()
    return (
        *(script.kind.name, str(_name(world, script.home)), script.language, text, script.order),
        *(script.traversal, script.is_enabled, script.joint_bases, script.full_results),
        *(script.stops_at_errors, script.threaded),
    )
