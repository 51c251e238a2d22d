"""Load a scene from a file: MJCF, URDF or V-REP's own, prepared through MjSpec to represent V-REP's names and joint
modes.

Preparation adds, it does not remove:
* names for elements without one, so that an edit finds every element again;
* for every hinge and slide joint without a plain actuator a velocity actuator with gain 0, which exerts nothing until
  the joint's motor is switched on: no later mode needs another compile;
* the integrator `implicitfast` in place of the explicit ones, Euler and RK4: servos with the file's own gains are stiff
  in velocity, and unstable with those;
* constraints, where the file switches them off: V-REP's motors are constraints;
* all angles in radians: parts of files in degrees and of files in radians can then be combined.
"""

from __future__ import annotations

import copy
import functools
import logging
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import mujoco

from simx_server.scene import physics_warnings
from simx_server.scene.assets.asset_files import AssetFiles, make_room
from simx_server.scene.assets.filing import file_assets
from simx_server.scene.dependencies import add_dependencies
from simx_server.scene.editing.in_place.slots import Slots
from simx_server.scene.naming.names import INTERNAL
from simx_server.scene.objects import Scene
from simx_server.scene.poses.start import StartKey
from simx_server.scene.spec_elements import bodies_of
from simx_server.scene.tree import build_scene

from .annotations import SceneError, read_annotations
from .jacobian import store_loops_fully
from .model_copies import copy_models
from .mounting import mount_bodies
from .sources import Sources
from .specs import one_line, read_scene
from .surroundings import default_scene as default_spec
from .urdf.recognising import is_urdf

__all__ = ["ADDED_ACTUATOR", "SceneError", "default_scene", "empty_scene", "load_scene", "prepare"]

logger = logging.getLogger(__name__)

ADDED_ACTUATOR = INTERNAL + "motor:"
"""Prefix of the names of added actuators; the rest is the joint's name."""


def take_weight(model: mujoco.MjModel, names: set[str]) -> bool:
    """Make bodies weigh nothing, in the model only: the spec keeps their mass for their release.

    Returns whether there are any.
    """
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name) for name in names]
    present = [body for body in ids if body >= 0]
    if present:
        model.body_mass[present] = 0.0
        model.body_inertia[present] = 0.0
    return bool(present)


ITERATIONS = ("iterations", "ls_iterations", "noslip_iterations", "ccd_iterations", "sdf_iterations")
MOST_ITERATIONS = 10_000
"""Most iterations of each solver in a physics step, which cannot be interrupted; MuJoCo's defaults are 100 at most."""

LONGEST_STEP = 10.0
"""Longest physics step in seconds, and longest simulation step."""


def load_scene(
    path: str | Path, sources: Sources | None = None, name: str | None = None
) -> tuple[Scene, mujoco.MjModel]:
    """Read, prepare and compile a file.

    Args:
        sources: search folders for the files that it names, beyond its own folder.
        name: name of the file in messages, by default its own name.

    Returns:
        The scene and its compiled model.

    Raises:
        SceneError: the file cannot be a scene.
    """
    file = Path(path).resolve()
    read = read_scene(file, sources, name)
    scene, model = build(read.spec, file if name is None else file.with_name(name))
    scene.import_report, scene.vrep_source = read.report, read.source
    return scene, model


def load_text(xml: str) -> tuple[Scene, mujoco.MjModel]:
    """Load MJCF or URDF given as text, as `load_scene`. Raises SceneError."""
    try:
        data = xml.encode()
        if is_urdf(data):
            from .urdf.reading import read_urdf

            spec = read_urdf(data, "the scene text", None, Sources.of())
        else:
            spec = mujoco.MjSpec.from_string(xml)
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise SceneError(f"cannot read the scene text: {one_line(error)}") from error
    return build(spec, None)


def empty_scene() -> tuple[Scene, mujoco.MjModel]:
    """Return the scene of a simulation that has loaded none: gravity, no objects."""
    prepared, compiled = _compiled_nothing()
    spec, model = prepared.copy(), copy.copy(compiled)
    scene = build_scene(spec, model, read_annotations(spec), None)
    scene.files = AssetFiles()
    return scene, model


@functools.cache
def _compiled_nothing() -> tuple[mujoco.MjSpec, mujoco.MjModel]:
    """Return a prepared empty spec and its model, for copies: every simulation starts with them."""
    spec = mujoco.MjSpec()
    prepare(spec)
    return spec, compile_spec(spec)


def default_scene(sources: Sources) -> tuple[Scene, mujoco.MjModel]:
    """Return the scene that remains after closing: V-REP's floor, lights and view cameras."""
    return build(default_spec(sources), None)


def build(spec: mujoco.MjSpec, path: Path | None) -> tuple[Scene, mujoco.MjModel]:
    """Prepare and compile a spec. Raises SceneError."""
    try:
        return _build(spec, path)
    except UnicodeDecodeError as error:
        raise SceneError(f"a name or text of the scene is not UTF-8: {error}; save the file so") from None


def _build(spec: mujoco.MjSpec, path: Path | None) -> tuple[Scene, mujoco.MjModel]:
    annotations = read_annotations(spec)
    key = StartKey.take_from(spec)
    try:
        prepare(spec)
        add_dependencies(spec, annotations)
        mounted = mount_bodies(spec, annotations)
        mounted |= copy_models(spec, annotations, mounted)
        file_assets(spec)
        files = AssetFiles()
        model = compile_spec(spec, files=files)
    except UnicodeDecodeError:
        raise
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        name = path.name if path is not None else spec.modelname
        raise SceneError(f"cannot compile '{name}': {one_line(error)}") from error
    if not 0 < model.opt.timestep <= LONGEST_STEP:
        raise SceneError(
            f"option timestep is {model.opt.timestep}; valid is a number above 0, up to {LONGEST_STEP} s"
        )
    for name in ITERATIONS:
        if (count := getattr(model.opt, name)) > MOST_ITERATIONS:
            raise SceneError(f"option {name} is {count}; at most {MOST_ITERATIONS} are valid")
    scene = build_scene(spec, model, annotations, path)
    scene.files = files
    if key is not None:
        scene.start = key.of(model)
    scene.welded_bodies |= mounted
    _weigh_nothing(scene, model)
    scene.welded_bodies |= {
        item.element_name
        for item in scene.objects.values()
        if item.element == "body" and not item.annotations.get("shape", {}).get("static", True)
    }
    return scene, model


def _weigh_nothing(scene: Scene, model: mujoco.MjModel) -> None:
    """Make the static shapes that ride on moving bodies weigh nothing, as in V-REP."""
    moving = {
        item.element_name
        for item in scene.objects.values()
        if item.element == "body"
        and item.annotations.get("shape", {}).get("static", False)
        and model.body_weldid[item.id] != 0
    }
    scene.weightless_bodies |= moving
    if take_weight(model, moving):
        mujoco.mj_setConst(model, mujoco.MjData(model))


def compile_spec(
    spec: mujoco.MjSpec,
    level: int = logging.WARNING,
    files: AssetFiles | None = None,
    slots: Slots | None = None,
    is_draft: bool = False,
) -> mujoco.MjModel:
    """Compile a copy of a spec and log MuJoCo's warnings, such as deprecated attributes. Raises as `spec.compile`.

    A spec that was compiled takes ten times as long to copy, and to delete something of.

    Args:
        level: of the warnings in the log.
        files: keeps the spec's files in memory for the next compile.
        slots: the model gets these too.
        is_draft: the spec is compiled, not a copy; the caller does not use it again.
    """
    make_room()
    if not is_draft:
        spec = spec.copy()
    if slots is not None:
        slots.add_to(spec)
    with physics_warnings.collected() as told:
        model = (files or AssetFiles()).compile(spec)
    store_loops_fully(model)
    for warning in told:
        logger.log(level, "mujoco: %s", warning)
    return model


def prepare(spec: mujoco.MjSpec) -> None:
    """Name unnamed elements, give joints an actuator, use radians, choose the integrator (see the module's text)."""
    # Fusing would drop the names of URDF links that are fixed to another.
    spec.compiler.fusestatic = False
    bodies = bodies_of(spec)
    _name_elements(spec, bodies)
    _use_radians(spec, bodies)
    for body in bodies:
        if body.sleep in _MAY_SLEEP:  # bodies with motors must not sleep: a new target would not wake them
            body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_AUTO
    driven = {a.target for a in spec.actuators if a.trntype in _JOINT_DRIVES and is_plain(a)}
    for joint in _leaves(bodies, "joints"):
        if (
            joint.type in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
            and joint.name not in driven
        ):
            _add_motor(spec, joint.name)
    _keep_motors_possible(spec)
    if spec.option.integrator in _EXPLICIT:
        spec.option.integrator = int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
        logger.debug(
            "integrator implicitfast is used in place of an explicit one: stiff joint motors need it"
        )


def _keep_motors_possible(spec: mujoco.MjSpec) -> None:
    """Replace flags that switch off friction loss, which motors are made of, by what has the same effect otherwise."""
    option = spec.option
    if not option.disableflags & (_DISABLE.mjDSBL_CONSTRAINT | _DISABLE.mjDSBL_FRICTIONLOSS):
        return
    if option.disableflags & _DISABLE.mjDSBL_CONSTRAINT:
        option.disableflags |= _DISABLE.mjDSBL_CONTACT | _DISABLE.mjDSBL_LIMIT | _DISABLE.mjDSBL_EQUALITY
    option.disableflags &= ~(_DISABLE.mjDSBL_CONSTRAINT | _DISABLE.mjDSBL_FRICTIONLOSS)
    for each in (*spec.joints, *spec.tendons):
        each.frictionloss = 0.0


_DISABLE = mujoco.mjtDisableBit

_EXPLICIT = (mujoco.mjtIntegrator.mjINT_EULER, mujoco.mjtIntegrator.mjINT_RK4)
_MAY_SLEEP = (mujoco.mjtSleepPolicy.mjSLEEP_ALLOWED, mujoco.mjtSleepPolicy.mjSLEEP_INIT)
_JOINT_DRIVES = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)


def is_plain(actuator: Any) -> bool:
    """Return whether an actuator may be rewritten as a velocity servo (gain and bias): no dynamics, one gear."""
    return (
        actuator.dyntype == mujoco.mjtDyn.mjDYN_NONE
        and actuator.gaintype == mujoco.mjtGain.mjGAIN_FIXED
        and actuator.biastype in (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)
        and actuator.gear[0] != 0
        and actuator.delay == 0
    )


def _add_motor(spec: mujoco.MjSpec, joint: str) -> None:
    motor = spec.add_actuator(name=ADDED_ACTUATOR + joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    motor.dyntype = mujoco.mjtDyn.mjDYN_NONE
    motor.gainprm[:] = 0
    motor.biasprm[:] = 0
    # A file's default class may limit or gear every actuator; this one must be neutral.
    motor.gear[:] = (1, 0, 0, 0, 0, 0)
    motor.ctrllimited = motor.forcelimited = motor.actlimited = int(mujoco.mjtLimited.mjLIMITED_FALSE)


def _leaves(bodies: Sequence[Any], many: str) -> list[Any]:
    return [leaf for body in bodies for leaf in getattr(body, many)]


def _name_elements(spec: mujoco.MjSpec, bodies: Sequence[Any]) -> None:
    below = [body for body in bodies if body.name != "world"]
    _give_names([b for b in below if b.geoms], "shape")
    _give_names([b for b in below if not b.geoms], INTERNAL + "body")
    joints = _leaves(bodies, "joints")
    _give_names([j for j in joints if j.type != mujoco.mjtJoint.mjJNT_FREE], "joint")
    _give_names([j for j in joints if j.type == mujoco.mjtJoint.mjJNT_FREE], INTERNAL + "free")
    _give_names(_leaves(bodies, "cameras"), "camera")
    _give_names(_leaves(bodies, "lights"), "light")
    for elements, stem in (
        (_leaves(bodies, "geoms"), "geom"), (_leaves(bodies, "sites"), "site"), (spec.tendons, "tendon"),
        (spec.actuators, "actuator"), (spec.equalities, "equality"), (spec.sensors, "sensor"),
    ):  # fmt: skip
        _give_names(elements, INTERNAL + stem)


def _use_radians(spec: mujoco.MjSpec, bodies: Sequence[Any]) -> None:
    """Convert angles as MuJoCo's compiler would: limits and references of joints, orientations as quaternions."""
    turned = [*bodies, *(leaf for many in _TURNED for leaf in _leaves(bodies, many))]
    joints = _leaves(bodies, "joints")
    for joint in joints:
        if joint.compiler.degree:
            if joint.type in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_BALL):
                joint.range[:] = [math.radians(angle) for angle in joint.range]
            if joint.type == mujoco.mjtJoint.mjJNT_HINGE:
                joint.ref, joint.springref = math.radians(joint.ref), math.radians(joint.springref)
    for element in turned:
        for quat, alternative in (("quat", "alt"), ("iquat", "ialt")):
            orientation = getattr(element, alternative, None)
            if orientation is not None and orientation.type != mujoco.mjtOrientation.mjORIENTATION_QUAT:
                sequence, degree = element.compiler.eulerseq, bool(element.compiler.degree)
                getattr(element, quat)[:] = spec.resolve_orientation(degree, sequence, orientation)
                orientation.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    for element in (*joints, *turned):
        element.compiler.degree = False
    spec.compiler.degree = False


_TURNED = ("geoms", "sites", "cameras", "frames")
"""Lists of a body whose elements have an orientation."""


def _give_names(elements: Iterable[Any], stem: str) -> None:
    elements = list(elements)
    taken = {element.name for element in elements}
    count = 0
    for element in elements:
        if not element.name:
            count += 1
            while f"{stem}{count}" in taken:
                count += 1
            element.name = f"{stem}{count}"
