"""The list of what the node offers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..annotated.drives import Drives
from ..annotated.helper import Helper
from ..annotated.imu import Imus
from ..annotated.joint_groups import JointGroups
from ..annotated.ranges import Ranges, Scans
from ..controllers.controllers import Controllers
from ..endpoints import Content, Context
from ..standard.simulate_steps import SimulateSteps
from ..standard.standard import Standard
from .cameras import Cameras
from .clock import Clock
from .control import Control
from .diagnostics import Diagnostics
from .joint_commands import JointCommands
from .joint_states import JointStates
from .parameters import NodeParameters
from .rosout import Rosout
from .transforms import Transforms

CONTENT: Sequence[Callable[[Context], Content]] = (
    Clock,
    JointStates,
    JointGroups,
    Transforms,
    Scans,
    Ranges,
    Imus,
    Cameras,
    JointCommands,
    Drives,
    Controllers,
    Helper,
    Control,
    Standard,
    SimulateSteps,
    NodeParameters,
    Diagnostics,
    Rosout,
)
"""One object of each is made with the gateway. Topics of one moment leave in this order."""
