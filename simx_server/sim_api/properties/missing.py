"""CoppeliaSim's properties that this server does not have, and the reasons."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

_ENGINE = "the engine here is MuJoCo, whose other settings are written in the scene's MJCF"

_PREFIXES = {
    "bullet.": _ENGINE,
    "ode.": _ENGINE,
    "vortex.": _ENGINE,
    "newton.": _ENGINE,
    "mujoco.": _ENGINE,
    "mov": "there is no mouse to move objects with",
    "povray.": "images are not rendered by POV-Ray",
    "machine": "this server has no licence that is tied to a machine",
    "dongle": "this server has no licence that is tied to a machine",
}

_NAMES = {
    "scenes and models are files that people write, and have no such note": """
        acknowledgment dna finalSaveRequest modelAcknowledgment modelHash persistentUid
        saveCalculationStructs
    """,
    "this server has no add-ons": "addOns",
    "the form of a mesh and its texture come from the scene's file": """
        applyCulling applyShadingAngle applyShowEdges flipFaces culling shadingAngle showEdges
    """,
    "assembly is not available": "assemblyTag",
    "it concerns the display in a window, and this server has none": """
        cameraSize graphSize hierarchyColor lightSize
        parentAsManipulationProxy rotationEnabled scriptSize
        trackedObjectHandle translationEnabled
    """,
    "objects of a collection are compared with those of another one": "collectionSelfCollisionIndicator",
    "the colours of points and voxels are set, and not read": "colors",
    "all points are drawn": "pointDisplayFraction",
    "colours are set when points are inserted": "randomColors",
    "an octree is drawn as it was created": "showPoints",
    "the log has the levels of the server's flag --log-level": """
        consoleVerbosity dialogVerbosity statusbarVerbosity
    """,
    "motion profiles are for joints outside force mode": "dynPosMode dynVelMode",
    "there are no events of objects": "emitDepthChangedEvent emitImageChangedEvent",
    "the limits of a joint are part of physics": "enforceLimits",
    _ENGINE: "engineProperties",
    "physics knows how static shapes move without it": "kinematic",
    "it describes fields of a window, and this server has none": "objectMetaInfo",
    "a script that an error stopped starts again with the next run": "resetAfterSimError restartOnError",
    "a joint turns or slides; couple two joints by an equality of the MJCF": "screwLead",
    "a shape becomes dynamic only by its property 'dynamic'": "setToDynamicWithParent",
    "the bodies that sleep at first are written in the scene's MJCF": "startInDynSleepMode",
    "images are rendered on request": "stepsPerRendering",
    "the server pauses on request only": "timeToPause",
    "volumes are exact": "volume_faces volume_subdivisions",
}
"""Names by reasons."""

MISSING: Mapping[str, str] = MappingProxyType(
    {name: why for why, names in _NAMES.items() for name in names.split()}
)
"""Names and reasons."""


def reason(name: str) -> str | None:
    """Return the reason why a property of CoppeliaSim does not exist here; None for an unknown name."""
    if name in MISSING:
        return MISSING[name]
    return next((why for prefix, why in _PREFIXES.items() if name.startswith(prefix)), None)
