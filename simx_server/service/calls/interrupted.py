"""A batch whose rest waits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol.messages import Call, Reply
from simx_client.protocol.python.light_dataclass import dataclass

if TYPE_CHECKING:
    from simx_server.service.monitoring.log_of_calls import Called

    from .background import Unfinished


@dataclass(eq=False)
class Interrupted:
    """A batch whose rest waits for a simulation step: the calls behind a trigger, or a paced call and later ones."""

    replies: list[Reply]
    """Replies to the calls before."""

    rest: list[Call]
    waits_for_trigger: bool = True
    """If False, it waits for any simulation step: the first call of the rest is paced."""

    is_slice: bool = False
    """It does not wait for a simulation step, but until others were served."""

    noted: Called | None = None
    """That call, where a history notes it."""

    problem: str = ""
    """Why the first call of the rest waits in vain for a simulation step."""

    call: Unfinished | None = None
    """It does not wait for a simulation step, but for a step of this call, which stands in front of the rest."""

    rounds_left: int = 0
    """If not 0, it does not wait for a simulation step, but for first images, and at most for this number of
    rounds of the server loop."""

    @property
    def has_waited_for_step(self) -> bool:
        """Return whether its first call was paced and may be executed now."""
        is_paced = not (self.waits_for_trigger or self.is_slice or self.call or self.rounds_left)
        return is_paced and not self.problem
