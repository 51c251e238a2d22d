"""A V-REP file as plain objects: what `reading.py` returns and `conversion/` takes.

Units are those of the file: metres, radians, kilograms, newtons. Quaternions are w, x, y, z. Handles belong to the
file.
"""

from __future__ import annotations

from .common import (
    Color,
    Engine,
    EngineValues,
    Material,
    UserParameter,
    Volume,
    VrepObject,
)
from .file import Settings, VrepFile
from .joints import Dummy, ForceSensor, Joint, JointType
from .paths import Graph, GraphCurve, GraphStream, Path, PathPoint
from .registered import (
    Button,
    Collection,
    IkElement,
    IkGroup,
    MotionPlanning,
    OldUI,
    Pair,
    PathPlanning,
    Script,
)
from .sensors import (
    Camera,
    Filter,
    Light,
    OtherObject,
    ProximitySensor,
    VisionSensor,
)
from .shapes import (
    Leaf,
    PointCloud,
    Primitive,
    Shape,
    Surface,
    Texture,
    TextureUse,
)

__all__ = [
    "Button",
    "Camera",
    "Collection",
    "Color",
    "Dummy",
    "Engine",
    "EngineValues",
    "Filter",
    "ForceSensor",
    "Graph",
    "GraphCurve",
    "GraphStream",
    "IkElement",
    "IkGroup",
    "Joint",
    "JointType",
    "Leaf",
    "Light",
    "Material",
    "MotionPlanning",
    "OldUI",
    "OtherObject",
    "Pair",
    "Path",
    "PathPlanning",
    "PathPoint",
    "PointCloud",
    "Primitive",
    "ProximitySensor",
    "Script",
    "Settings",
    "Shape",
    "Surface",
    "Texture",
    "TextureUse",
    "UserParameter",
    "VisionSensor",
    "Volume",
    "VrepFile",
    "VrepObject",
]
