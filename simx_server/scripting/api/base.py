"""What every part of the ``sim`` object has: the simulation, and whose script is calling."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol import constants

if TYPE_CHECKING:
    from ...simulation import Simulation

HANDLE_SELF = constants.sim_handle_self


class ApiPart:
    """The functions of one topic; public methods are functions of ``sim`` by the same name.

    Annotations say what a script may pass, see `scripting/signature.py`. What a method returns is what the script
    gets: None is nil, a list is a table, a tuple is several results.
    """

    def __init__(self, sim: Simulation, owner: int, signal_owner: object) -> None:
        """`owner`: the object the script belongs to; `signal_owner`: under what its signals are kept."""
        self._sim = sim
        self._owner = owner
        self._signal_owner = signal_owner

    def _self(self, handle: int) -> int:
        return self._owner if handle == HANDLE_SELF else handle

    def _adjusted(self, name: str) -> str:
        """V-REP's suffix rule: in the script of ``Robot#1`` the plain name ``Wheel`` means ``Wheel#1``."""
        own = self._sim.scene.get(self._owner).name
        if "#" in name or name.startswith(("/", ".", ":")) or "#" not in own:
            return name
        plain, at, suffix = name.partition("@")
        return f"{plain}#{own.rsplit('#', 1)[1]}{at}{suffix}"
