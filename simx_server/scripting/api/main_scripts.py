"""What the main script of a V-REP scene calls in its phases, as the default one does.

Here the server itself does all of it: physics comes between actuation and sensing; sensors, collisions and distances
are measured when they are read; threads go on before actuation. Only the child scripts wait for a main script to call
them. So a main script that leaves something out does not leave it undone; Boolean parameters switch things off.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from ...errors import CommandError
from ..bodies import CALL_TYPES
from ..interpreter import Constant
from ..script import ScriptKind
from .base import ApiPart

_ACTUATION = CALL_TYPES["syscb_actuation"]
_CALLED = {_ACTUATION: "sysCall_actuation", CALL_TYPES["syscb_sensing"]: "sysCall_sensing"}


class MainScriptFunctions(ApiPart):
    """For main scripts; what a function handles is a number where V-REP counted."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        "scriptthreadresume_launch": -2,
        "scriptthreadresume_allnotyetresumed": -1,
        "scriptthreadresume_default": 0,
        "scriptthreadresume_actuation_first": 1,
        "scriptthreadresume_actuation_last": 2,
        "scriptthreadresume_sensing_first": 3,
        "scriptthreadresume_sensing_last": 4,
        "scriptthreadresume_custom": 5,
    }

    def handleChildScripts(self, call_type: int = _ACTUATION, *_values: Any) -> int:
        """Call a phase of all child scripts; how many have it. For actuation their threads go on first.

        Partly: values for the child scripts are not handed on; init and cleanup come by themselves, and count 0.
        """
        if self._script.kind != ScriptKind.MAIN:
            raise CommandError(
                "only a main script handles the child scripts; they are called without one too"
            )
        if call_type not in CALL_TYPES.values():
            raise CommandError(
                f"{call_type} is no phase; those are sim.syscb_init, actuation, sensing, cleanup and so on"
            )
        function = _CALLED.get(call_type)
        return 0 if function is None else self._world.scripts.handle_children(function)

    def launchThreadedChildScripts(self) -> int:
        """Threads begin with the simulation: none is left to launch."""
        return 0

    def resumeThreads(self, _location: int = 0) -> int:
        """Partly: threads go on before the actuation of child scripts, none anywhere else."""
        return 0

    def handleCustomizationScripts(self, _call_type: int, *_values: Any) -> int:
        """Partly: customization scripts are called by the server, after the child scripts."""
        return 0

    def handleAddOnScripts(self, _call_type: int, *_values: Any) -> int:
        """There are no add-ons with phases."""
        return 0

    def handleSandboxScript(self, _call_type: int, *_values: Any) -> int:
        """There is no sandbox script."""
        return 0

    def handleDynamics(self, _seconds: float) -> int:
        """Partly: physics comes after the actuation of all scripts; a Boolean parameter switches it off."""
        return 1

    def handleSimulationStart(self) -> None:
        """Everything is started when a main script is called first."""

    def handleSensingStart(self) -> None:
        """Sensing begins by itself."""

    def handleJointMotion(self) -> int:
        """Partly: joints in motion mode move with the physics."""
        return 0

    def handleMechanism(self, _mechanism: int) -> int:
        """There are no mechanisms of V-REP's geometric constraint solver."""
        return 0

    def handleMill(self, _mill: int) -> int:
        """There are no mills."""
        return 0

    def resetMill(self, _mill: int) -> int:
        """There are no mills."""
        return 0

    def openModule(self, _module: int | str) -> int:
        """There are no plugins with start and end: 0 were called."""
        return 0

    def closeModule(self, _module: int | str) -> int:
        """As sim.openModule."""
        return 0

    def handleModule(self, _module: int | str, _is_sensing: bool = False) -> int:
        """As sim.openModule."""
        return 0
