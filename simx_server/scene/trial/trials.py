"""The server's side of trials: the files to be tried, the result of a trial, and the files after a success."""

from __future__ import annotations

import dataclasses
import logging
import signal
import sys
import threading
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from simx_server.errors import CommandError
from simx_server.limits import Limits
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.contents import contents_of
from simx_server.scene.formats.sources import Sources
from simx_server.service.calls.background import Steps, all_steps, beside

from .helper import Helper
from .kinds import SCENE
from .pool import Loan, Pool

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

logger = logging.getLogger(__name__)

_Result = TypeVar("_Result")

_GRACE = 5.0
"""Seconds that a new helper may take to start, and a killed child to end."""

_ERRORS: dict[str, type[CommandError]] = {"SceneError": SceneError, "CommandError": CommandError}

_PASSED = {
    -getattr(signal, name, 0): limit
    for name, limit in (("SIGXCPU", "load_seconds"), ("SIGPROF", "load_seconds"), ("SIGALRM", "load_wait"))
}
"""Exit codes of a child that a limit has ended."""


class Trials:
    """The trials of one simulation. Physics thread only; work done `beside` it does not touch the simulation."""

    def __init__(self, sim: LiveScene, *, tries_all: bool = False) -> None:
        """Start without a helper; the first trial starts one.

        Args:
            tries_all: whether the operator's own files are tried too.
        """
        self._sim = sim
        self.tries_all = tries_all
        self._pool = Pool()
        self.close: Callable[[], object] = weakref.finalize(self, self._pool.close)
        """End the helpers, and the running trials."""

    def use(self, started: Helper) -> None:
        """Use this helper for the first trials; it is closed with this object."""
        self._pool.add(started)

    def finish(self, steps: Steps[_Result]) -> _Result:
        """Execute all steps of a call before returning, as scripts need it; other clients are served meanwhile."""
        return all_steps(steps, self._sim.interruptions.serve_others, self._check)

    def _check(self) -> None:
        if self._sim.is_ending:
            raise CommandError("the server ends")

    def concern(self, file: Path, sources: Sources) -> bool:
        """Return whether a file must be tried: a client sent it or a file that it includes."""
        return self.tries_all or self._sim.files.client_files.are_named_by(file, sources)

    def tried(
        self, kind: str, file: Path, name: str, sources: Sources, *, is_short: bool = False
    ) -> Steps[Sources]:
        """Try a file and all that it names.

        Args:
            kind: the later use of the file, see `child`.
            name: the file's name in errors.
            sources: search folders for the files that it names.
            is_short: clients cannot be served meanwhile, so a second must be enough.

        Returns:
            Sources that contain only the tried files.

        Raises:
            CommandError, SceneError: an error in the file, or the limit that it passes.
        """
        limits = self._sim.limits
        if is_short:
            limits = dataclasses.replace(limits, load_seconds=min(1, limits.load_seconds), load_wait=2)
        request = {
            "kind": kind,
            "path": str(file),
            "name": name,
            "sources": sources.described(),
            "within": None if sources.within is None else [str(folder) for folder in sources.within],
            "limits": dataclasses.asdict(limits),
            "held": _held(self._sim) if kind != SCENE else 0,
        }
        reply = yield from self._asked(request, limits, name)
        result = reply.get("result")
        if result is None:
            raise self._ended(reply["exit"], reply["seconds"], name, limits)
        if "limit" in result:
            raise _refusal(limits, result["limit"], name)
        if "error" in result:
            raise _ERRORS[result["error"]](result["text"])
        logger.debug("'%s' was tried in %.3f s of processor time", name, reply["seconds"])
        return sources.holding(contents_of(result["files"])).for_one_read()

    def load(self, read: Callable[[], _Result]) -> Steps[_Result]:
        """Execute the tried work in the server. Raises the errors of `read`."""
        result = yield from beside(read)
        # Calls of others during the trial precede the ones from now on, also in a recording.
        self._sim.interruptions.script_point()
        return result

    def _asked(self, request: dict[str, Any], limits: Limits, name: str) -> Steps[dict[str, Any]]:
        """Return the reply to a request."""
        trial = _Trial(self._pool, request, limits.load_wait)
        try:
            reply = yield from beside(trial.make, trial.give_up)
        except TimeoutError:
            raise _refusal(limits, "load_wait", name) from None
        except EOFError:
            self._check()
            raise CommandError(
                f"'{name}' could not be tried before it is loaded: the process for that has ended; load it again"
            ) from None
        self._sim.interruptions.script_point()
        return reply

    def _ended(self, exit_code: int, seconds: float, name: str, limits: Limits) -> CommandError:
        """Return the reason why a child has no result; `seconds`: processor time that it took."""
        if exit_code in _PASSED:
            return _refusal(limits, _PASSED[exit_code], name)
        if exit_code == -signal.SIGKILL if sys.platform != "win32" else False:
            if seconds >= limits.load_seconds:  # the hard limit of processor time
                return _refusal(limits, "load_seconds", name)
            return CommandError(
                f"the system killed the process that tried '{name}', as it does when memory is short; make it smaller"
            )
        logger.warning("'%s' ended the process that tried it with code %d", name, exit_code)
        how = f"signal {-exit_code}" if exit_code < 0 else f"code {exit_code}"
        return SceneError(
            f"'{name}' crashes MuJoCo ({how}), so it is not loaded; make it smaller or less deeply nested"
        )


class _Trial:
    """One request to a helper."""

    def __init__(self, pool: Pool, request: dict[str, Any], seconds: float) -> None:
        """Store the request; `seconds`: wall time to wait for a helper; the child has separate limits."""
        self._pool, self._request, self._seconds = pool, request, seconds
        self._loan: Loan | None = None
        self._is_late = self._is_given_up = False

    def make(self) -> dict[str, Any]:
        """Make the trial and return its result. Raises TimeoutError, or EOFError: the helper has ended."""
        loan = self._loan = self._pool.take(self._seconds)
        clock = threading.Timer(self._seconds + _GRACE, self._end_late)
        clock.daemon = True
        clock.start()
        try:
            if self._is_given_up:
                raise EOFError
            return loan.helper.ask(self._request)
        except EOFError:
            loan.kill()
            if self._is_late:
                raise TimeoutError from None
            raise
        finally:
            clock.cancel()
            self._pool.give_back(loan)

    def give_up(self) -> None:
        """Discard the trial: its result is not needed any more."""
        self._is_given_up = True
        if (loan := self._loan) is not None:
            loan.kill()

    def _end_late(self) -> None:
        self._is_late = True
        self.give_up()


def _refusal(limits: Limits, limit: str, name: str) -> CommandError:
    return limits.reached(limit, f"'{name}' takes more; make it smaller")


def _held(sim: LiveScene) -> int:
    """Return the bytes of the scene that a model is added to."""
    return int(sim.model.nbuffer) + int(sim.data.nbuffer) + int(sim.data.narena)
