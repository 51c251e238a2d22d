"""CoppeliaSim's properties that this server does not have, and the reasons."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

_ENGINE = "the engine here is MuJoCo, whose other settings are written in the scene's MJCF"
_WINDOW = "it concerns the display in a window, and this server has none"
_SAVING = "scenes and models are files that people write, and have no such note"
_EDITING = "the form of a mesh and its texture come from the scene's file"

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
    "acknowledgment": _SAVING,
    "addOns": "this server has no add-ons",
    "applyCulling": _EDITING,
    "applyShadingAngle": _EDITING,
    "applyShowEdges": _EDITING,
    "assemblyTag": "assembly is not available",
    "cameraSize": _WINDOW,
    "collectionSelfCollisionIndicator": "objects of a collection are compared with those of another one",
    "colors": "the colours of points and voxels are set, and not read",
    "pointDisplayFraction": "all points are drawn",
    "randomColors": "colours are set when points are inserted",
    "showPoints": "an octree is drawn as it was created",
    "consoleVerbosity": "the log has the levels of the server's flag --log-level",
    "dialogVerbosity": "the log has the levels of the server's flag --log-level",
    "statusbarVerbosity": "the log has the levels of the server's flag --log-level",
    "dna": _SAVING,
    "dynPosMode": "motion profiles are for joints outside force mode",
    "dynVelMode": "motion profiles are for joints outside force mode",
    "emitDepthChangedEvent": "there are no events of objects",
    "emitImageChangedEvent": "there are no events of objects",
    "enforceLimits": "the limits of a joint are part of physics",
    "engineProperties": _ENGINE,
    "finalSaveRequest": _SAVING,
    "flipFaces": _EDITING,
    "graphSize": _WINDOW,
    "hierarchyColor": _WINDOW,
    "jointDiameter": _WINDOW,
    "jointLength": _WINDOW,
    "kinematic": "physics knows how static shapes move without it",
    "lightSize": _WINDOW,
    "culling": _EDITING,
    "shadingAngle": _EDITING,
    "showEdges": _EDITING,
    "modelAcknowledgment": _SAVING,
    "modelHash": _SAVING,
    "objectMetaInfo": "it describes fields of a window, and this server has none",
    "parentAsManipulationProxy": _WINDOW,
    "persistentUid": _SAVING,
    "resetAfterSimError": "a script that an error stopped starts again with the next run",
    "restartOnError": "a script that an error stopped starts again with the next run",
    "rotationEnabled": _WINDOW,
    "saveCalculationStructs": _SAVING,
    "screwLead": "a joint turns or slides; couple two joints by an equality of the MJCF",
    "scriptSize": _WINDOW,
    "sensorPointSize": _WINDOW,
    "sensorSize": _WINDOW,
    "setToDynamicWithParent": "a shape becomes dynamic only by its property 'dynamic'",
    "startInDynSleepMode": "the bodies that sleep at first are written in the scene's MJCF",
    "stepsPerRendering": "images are rendered on request",
    "timeToPause": "the server pauses on request only",
    "trackedObjectHandle": _WINDOW,
    "translationEnabled": _WINDOW,
    "volume_faces": "volumes are exact",
    "volume_subdivisions": "volumes are exact",
}

MISSING: Mapping[str, str] = MappingProxyType(_NAMES)
"""Names and reasons."""


def reason(name: str) -> str | None:
    """Return the reason why a property of CoppeliaSim does not exist here; None for an unknown name."""
    if name in MISSING:
        return MISSING[name]
    return next((why for prefix, why in _PREFIXES.items() if name.startswith(prefix)), None)
