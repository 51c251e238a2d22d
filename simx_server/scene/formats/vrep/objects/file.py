"""The whole file, and the settings of its scene."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.poses.poses import IDENTITY, Pose

from .common import Color, Engine, VrepObject
from .registered import (
    Collection,
    IkGroup,
    MotionPlanning,
    OldUI,
    Pair,
    PathPlanning,
    Script,
)
from .shapes import Texture


@dataclass(kw_only=True)
class Settings:
    """Settings of the scene; a model has the defaults."""

    time_step: float = 0.05
    has_custom_step: bool = True
    """Whether programs can change the time step, up to CoppeliaSim 4.3."""
    physics_step: float = 0.005
    is_real_time: bool = False
    engine: Engine = Engine.BULLET
    has_newer_bullet: bool = False
    """Whether Bullet is version 2.83, in place of 2.78."""
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    dynamics: bool = True
    background: tuple[Color, Color] = ((0.75, 0.75, 0.75), (0.75, 0.75, 0.75))
    """Above and below."""
    fog: Color = (0.0, 0.0, 0.0)
    """Background of vision sensors that have that of the environment."""
    ambient: Color = (0.4, 0.4, 0.4)
    visible_layers: int = 0x00FF
    acknowledgement: str = ""


@dataclass(kw_only=True)
class VrepFile:
    """A decoded file."""

    name: str
    """The file's name in messages."""
    serialization: int
    """Version of the format."""
    program: tuple[int, int, int]
    """Version of the program that saved it."""
    revision: int = 0
    is_model: bool = False
    settings: Settings = field(default_factory=Settings)
    objects: dict[int, VrepObject] = field(default_factory=dict[int, VrepObject])
    """By handle, in the order of the file."""
    textures: dict[int, Texture] = field(default_factory=dict[int, Texture])
    scripts: list[Script] = field(default_factory=list[Script])
    collections: list[Collection] = field(default_factory=list[Collection])
    ik_groups: list[IkGroup] = field(default_factory=list[IkGroup])
    path_plannings: list[PathPlanning] = field(default_factory=list[PathPlanning])
    motion_plannings: list[MotionPlanning] = field(default_factory=list[MotionPlanning])
    collisions: list[Pair] = field(default_factory=list[Pair])
    distances: list[Pair] = field(default_factory=list[Pair])
    uis: list[OldUI] = field(default_factory=list[OldUI])
    custom_data: dict[str, bytes] = field(default_factory=dict[str, bytes])
    """Custom data blocks of the scene, by tag."""
    thumbnail: NDArray[np.uint8] | None = None
    """(128, 128, 3), rows bottom first."""
    model_pose: Pose = IDENTITY
    """A model's pose and size where it was saved."""
    bounds: tuple[float, ...] = ()
    skipped: dict[str, int] = field(default_factory=dict[str, int])
    """Tags of top-level records that are not read, and how many there are."""
    notes: list[str] = field(default_factory=list[str])
    """Sentences about values that cannot be what the author meant, and were left out."""

    @property
    def version(self) -> str:
        """Return the program's version as text."""
        return ".".join(map(str, self.program))
