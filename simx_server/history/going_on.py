"""Start a new run from a step of the present or the last one.

The new run starts as every run does: what a stop restores is restored, and the scene's scripts start. Then the world is
set to the step: model and objects, MuJoCo's state, the joints with the memory of their controllers, signals, and the
parts that remember something (`Part.remember`). So physics continues bit for bit as if the run had not been
interrupted. Variables of scripts cannot be saved; `GoneOn.restarted` names the scripts that have started again.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scripting.script import ScriptKind

from .moments import Moment, restore

if TYPE_CHECKING:
    from simx_server.service.service import Service
    from simx_server.world.world import World

    from .history import History

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class GoneOn:
    """A new run; the simulation is paused."""

    step: int
    time: float
    restarted: list[str]
    """Scripts that have started again, and lack the values that their variables had."""


def go_on(service: Service, history: History, step: int) -> GoneOn:
    """Set the simulation to the end of a step, as a new run, and pause it. Steps after it are forgotten.

    Clients stay connected; those that step the simulation go on stepping it.

    Raises:
        CommandError: the step is not kept, or a script is being executed, which the stop would end.
    """
    world, sim = service.world, service.simulation
    moment, before = history.moment(step), history.before(step)
    if world.scripts.is_active or service.serving.is_active:
        raise CommandError("no new run can start while a script is being executed; call this from a client")
    if not sim.is_settled:
        raise CommandError("the simulation is about to start or to stop; try again")
    stepping = [session for session in service.clients.sessions.values() if session.is_stepping]
    start_from(service, moment, before, history.handle_at_start)
    sim.pause()
    history.cut(step)
    for session in stepping:
        session.set_stepping(True)
    restarted = restarted_scripts(world)
    logger.info(
        "a new run goes on from step %d, %.3f s%s",
        step,
        sim.time,
        f"; started again: {', '.join(restarted)}" if restarted else "",
    )
    return GoneOn(step, sim.time, restarted)


def start_from(service: Service, moment: Moment, before: Moment | None, next_handle: int) -> None:
    """Start a new run, and set it to a moment.

    Args:
        before: the moment before it; None: it is not known.
        next_handle: that of the next new object when the run of the moment started: scripts make their objects with
            the same handles again.

    Raises:
        CommandError: a script has stopped the new run.
    """
    world, sim = service.world, service.simulation
    with sim.going_back():
        try:
            sim.stop()
            sim.scene.next_handle = next_handle
            sim.start()
            if not sim.is_running:
                raise CommandError("a script has stopped the new run at its start")
            restore(world, moment, before)
        except CommandError:
            raise
        except Exception:
            sim.stop()  # a state that is restored in part must not be simulated
            raise


def restarted_scripts(world: World) -> list[str]:
    """Return the descriptions of the scripts that start with each run."""
    return [
        world.scripts.describe(script)
        for script in world.scripts.all()
        if script.kind is not ScriptKind.CUSTOMIZATION and script.interpreter is not None
    ]
