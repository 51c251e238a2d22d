"""Facts that all objects have, and what several kinds of them share."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

from simx_server.scene.poses.poses import IDENTITY, Pose

Color = tuple[float, float, float]


class Engine(IntEnum):
    """Physics engines, with the file's numbers."""

    BULLET = 0
    ODE = 1
    VORTEX = 2
    NEWTON = 3
    MUJOCO = 4
    PHYSX = 5


EngineValues = dict[Engine, tuple[list[float], list[int]]]
"""Parameters per engine: real numbers and whole numbers, in the file's order."""

UserParameter = tuple[str, str, str]
"""Name, unit and value of a parameter that a user sets and scripts read."""


@dataclass(kw_only=True)
class VrepObject:
    """Facts that all objects have."""

    handle: int
    parent: int = -1
    """Handle of the parent, -1 for none."""
    pose: Pose = IDENTITY
    """Relative to the parent; of a joint's child, relative to the joint's moving frame."""
    name: str = ""
    """The unique name, which simxGetObjectHandle finds."""
    alias: str | None = None
    """The name since CoppeliaSim 4.3, which paths use; it need not be unique. None in older files."""
    layers: int = 1
    """Visibility layers, 16 bits."""
    properties: int = 0
    """1 collidable, 2 measurable, 0x1F0 detectable (one bit per kind of sensor), 0x200 renderable."""
    model_properties: int = 0xF000
    """`sim_modelproperty_*` bits."""
    is_model_base: bool = False
    flags: int = 0x20
    """`sim_objectproperty_*` bits: 0x20 selectable, 0x100 not in its model's box, 0x1000 invisible to depth images."""
    order: int | None = None
    """Place among the siblings, since CoppeliaSim 4.3."""
    size_factor: float = 1.0
    """How much the object was scaled since it was made."""
    size_values: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """The same along each axis."""
    extension: str = ""
    acknowledgement: str = ""
    """Credits of the author."""
    custom_data: dict[str, bytes] = field(default_factory=dict[str, bytes])
    """Custom data blocks by tag."""
    parameters: list[UserParameter] = field(default_factory=list[UserParameter])
    """User parameters, since V-REP 3.6.1 revision 4; before, a child script has them."""
    references: dict[str, list[int]] = field(default_factory=dict[str, list[int]])
    """Handles of objects that scripts have stored with this one (sim.setReferencedHandles), by tag; -1 for others."""


@dataclass(kw_only=True)
class Material:
    """Looks of a surface, in one list of colours (`Cl0`)."""

    name: str = ""
    diffuse: Color = (1.0, 1.0, 1.0)
    light: Color = (0.0, 0.0, 0.0)
    """The colour of a light, in the list of a light."""
    specular: Color = (0.0, 0.0, 0.0)
    emission: Color = (0.0, 0.0, 0.0)
    opacity: float = 1.0
    """1 for an opaque surface."""
    shininess: int = 48
    """0..128: the greater, the smaller the highlight."""


@dataclass(kw_only=True)
class Volume:
    """The volume of a proximity sensor or mill; fields that a type does not use may be anything, also NaN."""

    type: str = "ray"
    """pyramid, cylinder, disc, cone or ray."""
    offset: float = 0.0
    range: float = 1.0
    x_size: float = 0.0
    y_size: float = 0.0
    x_size_far: float = 0.0
    y_size_far: float = 0.0
    radius: float = 0.0
    radius_far: float = 0.0
    angle: float = 0.0
    inside_gap: float = 0.0
    faces: tuple[int, int] = (0, 0)
    """Numbers of faces and faces far, or subdivisions; as in the file."""
