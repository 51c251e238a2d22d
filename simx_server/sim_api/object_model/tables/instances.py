"""Properties of worlds of inverse kinematics and what is in them, and of windows that programs make."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.kinematics import Constraint
from simx_server.kinematics.chain import largest_step
from simx_server.parts.instances import Instance
from simx_server.sim_api.object_model.enumerations import word_of
from simx_server.sim_api.object_model.instances.ik import IkElement, IkGroup, IkJoint, IkObject, IkWorld
from simx_server.sim_api.object_model.types import OBJECT, OBJECT_ARRAY, OBJECT_MAP
from simx_server.sim_api.object_model.values import Ref
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property
from simx_server.sim_api.properties.property_types import PropertyType

from .making import constant, refused

if TYPE_CHECKING:
    from simx_server.world.world import World

_Instance = TypeVar("_Instance", bound=Instance)


def _of(
    kind: type[_Instance],
    name: str,
    value_type: PropertyType,
    get: Callable[[_Instance], Any],
    put: Callable[[_Instance, Any], None] | None = None,
) -> Property:
    """Return a property of instances of a kind."""

    def read(world: World, handle: int) -> Any:
        return get(world.instances.get(handle, kind))

    def write(world: World, handle: int, value: Any) -> None:
        assert put is not None
        put(world.instances.get(handle, kind), value)

    return Property(name, value_type, read, None if put is None else write)


def _ref(item: Instance | None) -> Ref | None:
    return None if item is None else Ref(item.handle)


def _refs(items: list[Any]) -> list[Ref]:
    return [Ref(item.handle) for item in items]


def _map(items: dict[int, Any]) -> dict[int, Ref]:
    return {handle: Ref(item.handle) for handle, item in items.items()}


IK_CONSTANTS = {
    "constraint_x": 1,
    "constraint_y": 2,
    "constraint_z": 4,
    "constraint_position": 7,
    "constraint_alphabeta": 8,
    "constraint_gamma": 16,
    "constraint_orientation": 24,
    "constraint_pose": 31,
    "calc_notperformed": 1,
    "calc_cannotinvert": 2,
    "calc_outoftolerance": 16,
    "calc_largesteps": 32,
    "calc_boundshit": 64,
}
"""Members of the class `IK`."""

IK = (
    _of(IkWorld, "objects", OBJECT_MAP, lambda ik: _map(ik.objects)),
    _of(
        IkWorld,
        "joints",
        OBJECT_MAP,
        lambda ik: _map({handle: each for handle, each in ik.objects.items() if isinstance(each, IkJoint)}),
    ),
    _of(IkWorld, "groupList", OBJECT_ARRAY, lambda ik: _refs(ik.groups)),
    *(constant(name, t.INT, value) for name, value in IK_CONSTANTS.items()),
)


def _set_method(group: IkGroup, word: str) -> None:
    group.calculate(word, group.group.how.damping, group.group.how.iterations)


IK_GROUP = (
    _of(IkGroup, "elementList", OBJECT_ARRAY, lambda group: _refs(group.elements)),
    _of(IkGroup, "method", t.STRING, lambda group: group.method, _set_method),
    _of(
        IkGroup,
        "maxIterations",
        t.INT,
        lambda group: group.group.how.iterations,
        lambda group, value: group.calculate(group.method, group.group.how.damping, value),
    ),
    _of(
        IkGroup,
        "damping",
        t.FLOAT,
        lambda group: group.group.how.damping,
        lambda group, value: group.calculate(group.method, value, group.group.how.iterations),
    ),
    _of(IkGroup, "enabled", t.BOOL, lambda group: group.is_enabled, IkGroup.enable),
)


def _constrain(element: IkElement, bits: int) -> None:
    if bits & ~int(Constraint.POSE):
        raise CommandError(f"{bits} is not made of the bits IK.constraint_*")
    element.change(constraints=Constraint(bits))


def _pair(element: IkElement, name: str, values: list[float]) -> None:
    if len(values) != 2 or min(values) < 0:
        raise CommandError(f"'{name}' is two numbers that are not negative: for lengths and for angles")
    element.change(**{name: (values[0], values[1])})


IK_ELEMENT = (
    _of(IkElement, "jointList", OBJECT_ARRAY, lambda element: _refs(element.joints)),
    _of(IkElement, "base", OBJECT, lambda element: _ref(element.base)),
    _of(IkElement, "tip", OBJECT, lambda element: _ref(element.tip)),
    _of(IkElement, "target", OBJECT, lambda element: _ref(element.target)),
    _of(IkElement, "constraints", t.INT, lambda element: int(element.element.constraints), _constrain),
    _of(
        IkElement,
        "enabled",
        t.BOOL,
        lambda element: element.element.enabled,
        lambda element, value: element.change(enabled=value),
    ),
    _of(
        IkElement,
        "precision",
        t.FLOAT_ARRAY,
        lambda element: list(element.element.precision),
        lambda element, values: _pair(element, "precision", values),
    ),
    _of(
        IkElement,
        "weights",
        t.FLOAT_ARRAY,
        lambda element: list(element.element.weights),
        lambda element, values: _pair(element, "weights", values),
    ),
)


def _kind_of(world: World, handle: int) -> str:
    is_joint = world.instances.get(handle, IkObject).kind == IkJoint.kind
    return "joint" if is_joint else "dummy"


IK_OBJECT = (
    _of(IkObject, "sceneObjectHandle", t.INT, lambda item: item.scene_handle),
    Property("type", t.STRING, _kind_of),
)


def _set_passive(joint: IkJoint, is_passive: bool) -> None:
    passive = joint.world.environment.passive
    if is_passive:
        passive.add(joint.scene_handle)
    else:
        passive.discard(joint.scene_handle)


def _position(joint: IkJoint) -> float:
    return joint.world.environment.joint_position(joint.scene_handle)


def _set_position(joint: IkJoint, value: float) -> None:
    joint.world.environment.set_joint_position(joint.scene_handle, value)


def _set_configuration(joint: IkJoint, values: list[float]) -> None:
    if len(values) != 1:
        raise CommandError(f"'jointConfiguration' of this joint is a list of 1, not {len(values)}")
    _set_position(joint, values[0])


def _bounds(joint: IkJoint) -> list[float]:
    cyclic, least, extent = joint.world.environment.interval(joint.scene_handle)
    return [] if cyclic or extent >= _ENDLESS else [least, least + extent]


_ENDLESS, _LEAST_STEP = 1e9, 1e-6
_NO_BALLS = "spherical joints keep their pose in worlds of inverse kinematics"


def _of_joint(
    name: str, get: Callable[[World, IkJoint], float], put: Callable[[IkJoint, float], None]
) -> Property:
    def read(world: World, handle: int) -> float:
        return get(world, world.instances.get(handle, IkJoint))

    def write(world: World, handle: int, value: float) -> None:
        put(world.instances.get(handle, IkJoint), value)

    return Property(name, t.FLOAT, read, write)


def _weight(world: World, joint: IkJoint) -> float:
    usual = world.simulation.joints.ik_weight(joint.scene_handle)
    return joint.world.environment.weights.get(joint.scene_handle, usual)


def _set_weight(joint: IkJoint, value: float) -> None:
    joint.world.environment.weights[joint.scene_handle] = max(value, 0.0)


def _margin(_world: World, joint: IkJoint) -> float:
    return joint.world.environment.margins.get(joint.scene_handle, 0.0)


def _set_margin(joint: IkJoint, value: float) -> None:
    joint.world.environment.margins[joint.scene_handle] = max(value, 0.0)


def _step(_world: World, joint: IkJoint) -> float:
    environment, handle = joint.world.environment, joint.scene_handle
    is_hinge = environment.joint_type(handle) == c.sim_joint_revolute_subtype
    return environment.steps.get(handle, largest_step(is_hinge=is_hinge))


def _set_step(joint: IkJoint, value: float) -> None:
    joint.world.environment.steps[joint.scene_handle] = max(value, _LEAST_STEP)


IK_JOINT = (
    _of(
        IkJoint,
        "passive",
        t.BOOL,
        lambda joint: joint.scene_handle in joint.world.environment.passive,
        _set_passive,
    ),
    _of(IkJoint, "jointPosition", t.FLOAT, _position, _set_position),
    refused("jointQuaternion", t.QUATERNION, _NO_BALLS),
    _of(IkJoint, "jointConfiguration", t.FLOAT_ARRAY, lambda joint: [_position(joint)], _set_configuration),
    _of_joint("weight", _weight, _set_weight),
    _of_joint("limitMargin", _margin, _set_margin),
    _of_joint("maxStepSize", _step, _set_step),
    _of(
        IkJoint,
        "jointType",
        t.STRING,
        lambda joint: word_of("jointType", joint.world.environment.joint_type(joint.scene_handle)),
    ),
    _of(IkJoint, "bounds", t.FLOAT_ARRAY, _bounds),
)
