"""Calls that take several steps: what takes long is done in a thread of its own, and the physics thread goes on.

MuJoCo lets other threads run while it parses and compiles. So a handler that loads a file of a client is a generator:
it yields what is to be done beside the physics thread, and goes on there when that is done. ::

    def load_scene(sim, path) -> Steps[None]:
        scene, model = yield from beside(lambda: read(path))  # simulation steps and calls of others go on meanwhile
        sim.use(scene, model)
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from simx_client.protocol.commands import Command
from simx_server.errors import CommandError

Result = TypeVar("Result")

_GLANCE = 0.002
"""Seconds between two looks at what others have sent."""


class Task(Generic[Result]):
    """Work for a thread of its own."""

    def __init__(self, work: Callable[[], Result], give_up: Callable[[], object]) -> None:
        """Begin nothing yet.

        Args:
            work: what is done; it touches nothing of the simulation.
            give_up: has it end soon. Any thread; also when it is done already.
        """
        self._work = work
        self.give_up = give_up
        self.done: Future[Result] = Future()

    def start(self) -> None:
        """Begin. ``done`` tells when it is over, on that thread."""
        threading.Thread(target=self._run, name="simx-step", daemon=True).start()

    def _run(self) -> None:
        try:
            result = self._work()
        except BaseException as error:
            self.done.set_exception(error)
        else:
            self.done.set_result(result)


Steps = Generator[Task[Any], None, Result]
"""A call that takes several steps; what it returns is its result."""


@dataclass(eq=False)
class Unfinished:
    """A call of which a step is to be done beside the physics thread."""

    command: Command
    steps: Steps[Any]
    task: Task[Any]
    """The step."""

    def all_steps(self) -> Steps[Any]:
        """Yield this step, and those behind it."""
        yield self.task
        return (yield from self.steps)

    def abandon(self) -> None:
        """Give the call up, as its client has left or cannot wait for it."""
        self.task.give_up()
        self.steps.close()


def wait_for_step(call: Unfinished) -> Unfinished:
    """Leave the step to the caller of `Executor.execute`."""
    return call


def refuse_steps(call: Unfinished) -> None:
    """Refuse a call of a stream, which is executed after each simulation step and would take longer.

    Raises:
        CommandError: always.
    """
    call.abandon()
    raise CommandError("a file that a client sent cannot be loaded by a stream; call it with a blocking mode")


def beside(work: Callable[[], Result], give_up: Callable[[], object] = lambda: None) -> Steps[Result]:
    """One step, for ``yield from``: its result is that of `work`, and what `work` raises is raised."""
    task = Task(work, give_up)
    yield task
    return task.done.result()


def at_once(steps: Steps[Result]) -> Result:
    """Take all steps on the calling thread, which does nothing else meanwhile."""
    return all_steps(steps, lambda: None, lambda: None)


def all_steps(
    steps: Steps[Result], serve_others: Callable[[], object], check: Callable[[], object]
) -> Result:
    """Take all steps before returning; others are served meanwhile.

    Args:
        serve_others: called again and again while a step lasts.
        check: called so too; what it raises ends the steps.
    """
    while True:
        try:
            task = next(steps)
        except StopIteration as end:
            return end.value
        came = threading.Event()
        task.done.add_done_callback(lambda _, came=came: came.set())
        task.start()
        try:
            while not came.wait(_GLANCE):
                serve_others()
                check()
        except BaseException:
            task.give_up()
            steps.close()
            raise
