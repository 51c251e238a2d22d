"""Functions that the main script of a V-REP scene calls in its phases, as the default main script does.

The server itself does this work: physics runs between actuation and sensing; sensors, collisions and distances are
measured when they are read; threads are resumed before actuation. Only the child scripts wait for a main script to
call them, and customization scripts are called after it. So if a main script omits a call, the server still does the
work; Boolean parameters disable parts of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from simx_server.errors import Unsupported
from simx_server.scripting.bodies import CALL_TYPES
from simx_server.scripting.interpreter import Constant
from simx_server.scripting.script import ScriptKind
from simx_server.sim_api.base import ApiPart

_ACTUATION = CALL_TYPES["syscb_actuation"]
FAILED = -1
_CALLED = {_ACTUATION: "sysCall_actuation", CALL_TYPES["syscb_sensing"]: "sysCall_sensing"}


class MainScriptFunctions(ApiPart, effect="changes"):
    """Functions for main scripts; they return a number where V-REP returned a count."""

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

    def handleChildScripts(self, call_type: int = _ACTUATION, *values: Any) -> int:
        """Call a phase of all child scripts with these values and return how many have it. Before actuation their
        threads are resumed.

        Partly: init and cleanup are called automatically, and count as 0.
        """
        self._check_main(FAILED)
        function = _CALLED.get(call_type)
        return 0 if function is None else self._world.scripts.phases.handle_children(function, *values)

    def handleSimulationScripts(self, call_type: int = _ACTUATION, *values: Any) -> int:
        """Call a phase of all child scripts: the name since CoppeliaSim 4.7. Partly: as sim.handleChildScripts."""
        return self.handleChildScripts(call_type, *values)

    def handleSensingChildScripts(self) -> int:
        """Call the sensing of all child scripts. V-REP 2's form."""
        return self.handleChildScripts(CALL_TYPES["syscb_sensing"])

    def handleChildScript(self, handle: int, *values: Any) -> int:
        """Call the actuation of an object's child script; return 1, or 0 without one."""
        self._check_main(0)
        owner = self._sim.scene.get(self._self(handle)).handle
        return self._world.scripts.phases.handle_child(owner, "sysCall_actuation", *values)

    def _check_main(self, answer: int) -> None:
        if self._script.kind != ScriptKind.MAIN:
            raise Unsupported(
                "only a main script handles the child scripts; they are called without one too", answer
            )

    def delegateChildScriptExecution(self) -> int:
        """Return 0: the scripts of the objects below were called before this one, as in V-REP's default order."""
        return 0

    def handleEmbeddedScripts(self, call_type: int, *values: Any) -> int:
        """Call a phase of all child and customization scripts, in the order of the tree; return how many have it.

        Partly: other phases than actuation and sensing are called automatically, and count as 0.
        """
        self._check_main(FAILED)
        function = _CALLED.get(call_type)
        return 0 if function is None else self._world.scripts.phases.handle_embedded(function, *values)

    def handleMainScript(self) -> int:
        """Return 0: the main script is called in each simulation step."""
        return 0

    def handleExtCalls(self) -> None:
        """Do nothing: calls of clients are answered between the simulation steps."""

    def handleJoint(self, _joint: int, _seconds: float) -> int:
        """Return 1. Partly: joints in motion mode move with the physics."""
        return 1

    def handleVarious(self) -> int:
        """Return 1: the server does automatically what V-REP 2 did here."""
        return 1

    def enableWorkThreads(self, _count: int = -1) -> int:
        """Return 1: the server decides about its threads."""
        return 1

    def waitForWorkThreads(self) -> int:
        """Return 1: no work is left to wait for."""
        return 1

    def launchThreadedChildScripts(self) -> int:
        """Return 0: threads start with the simulation, so none is left to launch."""
        return 0

    def resumeThreads(self, _location: int = 0) -> int:
        """Return 0. Partly: threads are resumed before the actuation of child scripts, and at no other point."""
        return 0

    def handleCustomizationScripts(self, call_type: int, *values: Any) -> int:
        """Call a phase of all customization scripts now; return how many have it. Without this call they are called
        after the main script.

        Partly: other phases than actuation and sensing are called automatically, and count as 0.
        """
        self._check_main(FAILED)
        function = _CALLED.get(call_type)
        return 0 if function is None else self._world.scripts.phases.handle_customizations(function, *values)

    def handleAddOnScripts(self, _call_type: int, *_values: Any) -> int:
        """Return 0: add-ons with phases do not exist."""
        return 0

    def handleSandboxScript(self, _call_type: int, *_values: Any) -> int:
        """Return 0: the sandbox script has no call-backs."""
        return 0

    def handleDynamics(self, _seconds: float) -> int:
        """Return 1. Partly: physics runs after the actuation of all scripts; a Boolean parameter disables it."""
        return 1

    def handleSimulationStart(self) -> int:
        """Do nothing: everything is started before the first call of a main script."""
        return 1

    def handleSensingStart(self) -> int:
        """Do nothing: sensing starts automatically."""
        return 1

    def handleJointMotion(self) -> int:
        """Return 0. Partly: joints in motion mode move with the physics."""
        return 0

    def handleMechanism(self, _mechanism: int) -> int:
        """Return 0: mechanisms of V-REP's geometric constraint solver do not exist."""
        return 0

    def handleMill(self, _mill: int) -> int:
        """Return 0: mills do not exist."""
        return 0

    def resetMill(self, _mill: int) -> int:
        """Return 0: mills do not exist."""
        return 0

    def resetMilling(self, _object: int) -> int:
        """Return 0: mills do not exist, so no shape was cut."""
        return 0

    def openModule(self, _module: int | str) -> int:
        """Return 0, the number of plugins called: plugins with start and end do not exist."""
        return 0

    def closeModule(self, _module: int | str) -> int:
        """Return 0, as sim.openModule does."""
        return 0

    def handleModule(self, _module: int | str, _is_sensing: bool = False) -> int:
        """Return 0, as sim.openModule does."""
        return 0
