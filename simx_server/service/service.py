"""The service of clients as one value: everything that a gateway, a watcher or the loop uses, and the order of a turn.

`build_service` is the one place where it is made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, ClassVar

from simx_client.protocol.python.light_dataclass import dataclass

from .answers.outbox import Outbox
from .answers.publishing import Publisher
from .answers.replies import Messages
from .arrivals import Arrivals
from .calls.addresses import Addresses, CallsAtOnce
from .calls.batches import Batches
from .calls.busy import BusyDesk
from .calls.dispatch import Dispatch
from .calls.executor import Executor
from .calls.registry import Handler
from .calls.serving import Serving
from .clients.admission.unfinished import Unfinished
from .clients.clients import Clients
from .clients.returning import Returning
from .clock import Pacer
from .due import Due
from .ending import Ending
from .handling import Handling
from .meanwhile import Meanwhile
from .memory import Memory
from .monitoring.metrics import ImageTimes, Metrics
from .queue.inbox import Inbox
from .rounds import Rounds
from .watcher import Watchers

if TYPE_CHECKING:
    from simx_server.limits import Limits
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World

Stage = tuple[str, "Callable[[Service], Callable[[float], bool]]"]
"""The description of a stage of a turn, and its action: it takes the most seconds to wait; True ends the turn."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Service:
    """The parts of the service. Physics thread, except where a method says otherwise."""

    world: World
    simulation: Simulation
    pacer: Pacer
    queue: Inbox
    """Has the messages and events that wait. Any thread may add to it."""

    watchers: Watchers
    clients: Clients
    unfinished: Unfinished
    """Counts what is held of messages that have not arrived completely, at all gateways."""

    returning: Returning
    """The clients of a crashed server whose successor this is."""

    metrics: Metrics
    executor: Executor
    messages: Messages
    """Knows the times and headers of replies."""

    publisher: Publisher
    outbox: Outbox
    serving: Serving
    batches: Batches
    addresses: Addresses
    at_once: CallsAtOnce
    busy: BusyDesk
    ending: Ending
    due: Due
    handling: Handling
    arrivals: Arrivals
    rounds: Rounds
    meanwhile: Meanwhile

    TURN: ClassVar[tuple[Stage, ...]] = (
        ("clients learn what was dropped", lambda service: service.clients.report_dropped),
        ("paced calls go on if no step comes", lambda service: service.rounds.release_paced),
        ("one message is awaited, unless a round is due", lambda service: service.arrivals.await_one),
        ("all messages at hand are executed", lambda service: service.arrivals.take_all),
        ("the round that is due", lambda service: service.rounds.make_due),
    )
    """The stages of a turn of the loop, in their order. A stage may end the turn."""


def build_service(
    world: World,
    handlers: Mapping[str, Handler],
    pacer: Pacer,
    *,
    starting_port: int | None = None,
    queue: Inbox | None = None,
    images: ImageTimes | None = None,
) -> Service:
    """Return the service of a world.

    Args:
        starting_port: a client that comes by this port starts a stopped simulation, because in V-REP the service
            behind it existed only while a simulation ran.
        queue: takes what arrives; None: an empty one of the world's limits.
        images: counts the rendered images; None: there are none.
    """
    simulation = world.simulation

    def limits() -> Limits:
        return simulation.limits

    queue = queue or Inbox(limits)
    watchers = Watchers(simulation)
    metrics = Metrics(pacer, images=images)
    executor = Executor(Dispatch(world, handlers), metrics)
    messages = Messages(simulation, pacer)
    publisher, outbox = Publisher(executor, messages), Outbox(messages)
    serving = Serving(queue, watchers)
    clients = Clients(world, queue, metrics, watchers, serving, starting_port)
    sessions = clients.sessions
    returning, unfinished = Returning(), Unfinished(limits)
    ending = Ending(simulation, queue, sessions, executor)
    due = Due(world, sessions, pacer, returning, watchers)
    addresses = Addresses(world)
    batches = Batches(
        simulation, sessions, queue, serving, due, watchers, executor, publisher, outbox, addresses
    )
    busy = BusyDesk(queue, sessions, messages, executor, watchers)
    at_once = CallsAtOnce(addresses, simulation, sessions, watchers, executor, outbox)
    handling = Handling(simulation, queue, at_once, batches, outbox, busy, serving)
    meanwhile = Meanwhile(simulation, queue, clients, executor, outbox, serving, handling, ending)
    watchers.add(metrics, Memory(queue), ending, clients, batches.waiting, unfinished, returning)
    simulation.interruptions.serve(meanwhile.serve_others, meanwhile.is_end_wanted)
    return Service(
        world=world,
        simulation=simulation,
        pacer=pacer,
        queue=queue,
        watchers=watchers,
        clients=clients,
        unfinished=unfinished,
        returning=returning,
        metrics=metrics,
        executor=executor,
        messages=messages,
        publisher=publisher,
        outbox=outbox,
        serving=serving,
        batches=batches,
        addresses=addresses,
        at_once=at_once,
        busy=busy,
        ending=ending,
        due=due,
        handling=handling,
        arrivals=Arrivals(queue, handling, outbox, due, pacer),
        rounds=Rounds(
            world,
            sessions,
            pacer,
            metrics,
            publisher,
            batches.waiting,
            busy,
            serving,
            due,
            handling,
            watchers,
        ),
        meanwhile=meanwhile,
    )
