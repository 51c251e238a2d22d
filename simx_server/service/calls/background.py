"""Run calls that take several steps: slow work runs in a separate thread while the physics thread continues.

MuJoCo releases the interpreter while it parses and compiles. So a handler that loads a file of a client is a generator:
it yields the work to do beside the physics thread, and continues there when the work is done. ::

    def load_scene(sim, path) -> Steps[None]:
        scene, model = yield from beside(lambda: read(path))  # simulation steps and other calls continue meanwhile
        sim.use(scene, model)
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future
from typing import Any, Generic, TypeVar

from simx_client.protocol.commands import Command
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

Result = TypeVar("Result")

_GLANCE = 0.002
"""Seconds between two checks for messages of other clients."""


class Task(Generic[Result]):
    """Work for a separate thread."""

    def __init__(
        self, work: Callable[[], Result], give_up: Callable[[], object], *, may_be_skipped: bool = False
    ) -> None:
        """Make a task that has not started.

        Args:
            work: the function to run; it does not touch the simulation.
            give_up: makes it end soon. Any thread; also after it is done.
            may_be_skipped: the call goes on without the work where it cannot wait: it only saves time later.
        """
        self._work = work
        self.give_up = give_up
        self.done: Future[Result] = Future()
        self.may_be_skipped = may_be_skipped

    def start(self) -> None:
        """Start the work. ``done`` gets the result on that thread."""
        threading.Thread(target=self._run, name="simx-step", daemon=True).start()

    def _run(self) -> None:
        try:
            result = self._work()
        except BaseException as error:
            self.done.set_exception(error)
        else:
            self.done.set_result(result)


Steps = Generator[Task[Any], None, Result]
"""A call that takes several steps; its return value is its result."""


@dataclass(eq=False)
class Unfinished:
    """A call with a step to do beside the physics thread."""

    command: Command
    steps: Steps[Any]
    task: Task[Any]
    """The step."""

    def all_steps(self) -> Steps[Any]:
        """Yield this step, and those after it."""
        yield self.task
        return (yield from self.steps)

    def abandon(self) -> None:
        """Abandon the call, because its client has left or cannot wait for it."""
        self.task.give_up()
        self.steps.close()


def wait_for_step(call: Unfinished) -> Unfinished:
    """Leave the step to the caller of `Executor.execute`."""
    return call


def refuse_steps(call: Unfinished) -> Any:
    """Refuse a call of a stream, which would take longer than one simulation step; or return its result without a
    last step that may be skipped.

    Raises:
        CommandError: the step is necessary.
    """
    if call.task.may_be_skipped:
        try:
            next(call.steps)
        except StopIteration as end:
            return end.value
    call.abandon()
    raise CommandError(
        "a file of a client, or of V-REP, cannot be loaded by a stream; call it with a blocking mode"
    )


def beside(work: Callable[[], Result], give_up: Callable[[], object] = lambda: None) -> Steps[Result]:
    """Run `work` as one step, for ``yield from``: return its result, or raise what it raises."""
    task = Task(work, give_up)
    yield task
    return task.done.result()


def at_once(steps: Steps[Result]) -> Result:
    """Run all steps on the calling thread, which does nothing else meanwhile."""
    return all_steps(steps, lambda: None, lambda: None)


def all_steps(
    steps: Steps[Result], serve_others: Callable[[], object], check: Callable[[], object]
) -> Result:
    """Run all steps before returning, and serve other clients meanwhile.

    Args:
        serve_others: called repeatedly while a step runs.
        check: called as often; an exception from it ends the steps.
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


def after_all(futures: Sequence[Future[Any]], work: Callable[[], object]) -> None:
    """Run `work` when all futures are done, on the thread that finishes the last one."""
    if futures:
        first, *rest = futures  # a future that refers to itself by its callback would keep its image
        first.add_done_callback(lambda _: after_all(rest, work))
    else:
        work()
