"""The enumerations of API 2: names and numbers."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from simx_server.errors import CommandError

_TEXT = """
appFlavor: lite 0, edu 1, pro 2
codeLang: undefined -1, lua 0, python 1
dummyType: dynLoopClosure 0, dynTendon 7, neutral 8, assembly 9
forceSensorFilter: average 0, median 1
handle: app -13, scene -12, self -4, all -2, world -1
headlessMode: disabled 0, emulated 1, enabled 2
jointDynamicsCtrlMode: free 0, force 1, velocity 4, position 8, spring 12, custom 16
jointMode: kinematic 0, dependent 4, dynamic 5
jointType: revolute 10, prismatic 11, spherical 12
lightType: omnidirectional 1, spot 2, directional 3
markerOptions: local 1, cyclic 2, overlay 4
markerType: points 0, lines 1, triangles 2, spheres 7, squares 9, discs 10, cubes 11, cylinders 12, custom 13, tubes 14,
axes 15
materialComponent: diffuse 0, lightDiffuse 1, specular 2, emission 3
parentingMode: keepLocalPose 0, keepWorldPose 1, assembly 2
physicsEngine: bullet 0, ode 1, vortex 2, newton 3, mujoco 4, drake 5
platform: windows 0, macos 1, linux 2
primitiveType: none 0, plane 1, disc 2, cuboid 3, spheroid 4, cylinder 5, cone 6, heightfield 7, capsule 8
propertyReturns: invalidValue -9, invalidName -8, corrupt -7, typeMismatch -6, notRemovable -5, notWritable -4,
notReadable -3, unknownTarget -2, unknownProperty -1, unavailable 0, ok 1
proximitySensorType: pyramid 30, cylinder 31, disc 32, cone 33, ray 34
renderMode: openGl 0, colorCoded 2, povray 3, extRenderer 5, openGl3 7, oglImg 9, codedImg 10
sceneObjectType: shape 0, joint 1, graph 2, camera 3, dummy 4, proximitySensor 5, visionSensor 9, forceSensor 12,
light 13, ocTree 15, pointCloud 16, script 17, marker 18, customSceneObject 19
scriptExecOrder: first 0, normal 1, last 2
scriptState: unloaded 0, uninitialized 1, initialized 2, ended 3, error 8, suspended 16
scriptType: main 0, simulation 1, addon 2, customization 6, sandbox 8, passive 9
shapeType: simple 20, compound 21
simulationState: stopped 0, paused 8, running 17, lastBeforeStop 22
stringType: text 0, binary 1, buffer 2
textureApplyMode: modulate 0, decal 1, add 2
verbosity: useGlobal -1, none 100, errors 200, warnings 300, loadInfos 400, questions 410, scriptErrors 420,
scriptWarnings 430, scriptInfos 450, infos 500, debug 600, trace 700, traceLua 800, traceAll 900
"""


def _read() -> dict[str, Mapping[str, int]]:
    found: dict[str, Mapping[str, int]] = {}
    for line in _TEXT.strip().replace(",\n", ", ").splitlines():
        name, _, items = line.partition(": ")
        pairs = (item.rsplit(" ", 1) for item in items.split(", "))
        found[name] = MappingProxyType({word: int(number) for word, number in pairs})
    return found


ENUMERATIONS: Mapping[str, Mapping[str, int]] = MappingProxyType(_read())
"""Numbers by name, by enumeration."""


def number_of(enumeration: str, value: str | int) -> int:
    """Return the number of an item given by name or number. Raises CommandError: there is none."""
    items = ENUMERATIONS[enumeration]
    if isinstance(value, str) and value in items:
        return items[value]
    if not isinstance(value, str) and value in items.values():
        return value
    raise CommandError(
        f"'{str(value)[:40]}' is not in the enumeration {enumeration}; it has "
        + ", ".join(f"{word} {number}" for word, number in items.items())
    )


def word_of(enumeration: str, number: int) -> str:
    """Return the name of an item; the number as text, if it has none."""
    return next((word for word, each in ENUMERATIONS[enumeration].items() if each == number), str(number))
