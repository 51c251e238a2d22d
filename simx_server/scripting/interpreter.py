"""Interface between the server and the language of an embedded script.

`lua/` and `python/` are the two languages. A script has one interpreter as long as it runs; only the physics thread
uses it.

Values pass the interface as plain Python ones: None, bool, int, float, bytes (every string, whatever it holds), list,
dict (keys str or int) and `Function`; nested up to `MAX_DEPTH` levels. A call returns a list of results; a function
of the API returns a tuple of results. Any other value is a ScriptError.

**Threads.** A script has at most one thread of the server's (``sysCall_thread`` or ``sysCall_threadmain``), a
  coroutine
that runs only within `Interpreter.resume`, which is called once per simulation step. A function of the API that must
wait is a generator on the server's side: `Api.invoke` returns it instead of results, each of its yields means "until
the next simulation step", and its return value is the tuple of results. The interpreter advances it once immediately,
and if it yields, once at each further resumption of the calling coroutine; the generator's exceptions are those of
the
call. Outside a coroutine such a call is refused with `NOT_IN_A_THREAD` before the generator is advanced.

In addition, a thread switches automatically: when a call of the API ends more than `Switching.seconds` after the
thread's resumption, it waits for the next resumption, then returns its results, unless `Switching.level` is above 0.
The time is counted in calls and not by a clock, so that runs can be repeated bit for bit. A loop of the thread, also
one without calls, switches in the same way after a fixed number of iterations since the resumption. Where Lua cannot
yield (in a function that a C function such as ``table.sort`` calls) the loop continues.

**Other clients are served.** While a call into a script runs longer than ``TIMEOUT``, the interpreter calls
`Api.serve_others` every few milliseconds, from the physics thread and at a point where the script holds no lock. This
time does not count against the script's processor time. A Python script, whose process runs in parallel, also has a
limit in wall time.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Protocol, runtime_checkable

from simx_client.protocol.python.light_dataclass import dataclass

from ..errors import CommandError

TIME_LIMIT = 2.0
"""Processor seconds that one call into a script may take; well below the 5 s that a blocking client waits."""

ACTUATION, SENSING = PHASES = "sysCall_actuation", "sysCall_sensing"
"""Call-backs of each simulation step."""

MEMORY_LIMIT = 64 << 20
"""Maximum memory of one script in bytes."""

ENDING_LIMIT = 1.0
"""Wall seconds that a call into a script may take, also one to its cleanup, while the server is shutting down."""

TIMEOUT = 0.003
"""Seconds that a script may run before the server answers other clients, and between two such times."""

MAX_DEPTH = 16
"""Maximum nesting of tables in a value; deeper and recursive tables are an error."""

NOT_IN_A_THREAD = (
    "waits, so it works only in a thread: sysCall_thread, a threaded script, or a script's coroutine"
)

Constant = int | float | bool | str | dict[str, int]
"""Constant of a namespace; a dict is a table of constants, as ``simOMPL.Algorithm``."""

Waiting = Generator[None, None, tuple[Any, ...]]
"""A function of the API that is not complete yet: it yields once per simulation step and returns the results."""


OLD_SPACES: Mapping[str, str] = MappingProxyType(
    {
        "ExtCHAI3D_": "simCHAI3D",
        "ExtCustomUI_": "simUI",
        "ExtMtb_": "simMTB",
        "ExtOMPL_": "simOMPL",
        "ExtRosInterface_": "simROS",
        "ExtVision_": "simVision",
    }
)
"""Names that V-REP 3 gave to the functions of a namespace: ``simExtCustomUI_create`` is ``simUI.create``."""


class ScriptError(CommandError):
    """A script failed, or cannot be called: the text contains the script, the place and the reason."""


@runtime_checkable
class Function(Protocol):
    """A function that a script passed to the server; the same script gets it back as the function itself.

    A call after the script's end is a ScriptError.
    """

    def __call__(self, *arguments: Any) -> list[Any]:
        """Call the function with plain values and return all its results.

        Raises:
            ScriptError: the script failed or has ended.
        """
        ...


Plain = None | bool | int | float | bytes | str | list[Any] | tuple[Any, ...] | dict[Any, Any] | Function
"""A value that crosses the border; the server may also give a str for a string and a tuple for a list."""

_LAST_SECONDS, _LAST_CALLS = 0.02, 0.2
"""Seconds for loops and for calls of the API in a thread's last resumption, where a loop that waits for an event would
wait in vain.
"""


@dataclass(slots=True)
class Switching:
    """Automatic switching of a script's thread. The API's functions change it, the interpreter applies it."""

    level: int = 0
    """Above 0 the thread switches only in functions that wait."""

    seconds: float = 0.002
    """Time after a resumption until the next call of the API switches; V-REP's default."""

    is_last: bool = False
    """The run ends and the thread is resumed for the last time: the code after its loop must not be interrupted."""

    called: float = 0.0
    """Seconds that calls of the API by the thread count as, since its resumption."""

    spent: float = 0.0
    """Processor seconds of waits for images, and of API functions with separate limits, during the present call into
    the script.
    """

    is_free: bool = False
    """A function with a separate limit is at work: each call-back of the script that it makes has a whole limit."""

    edited: float = 0.0
    """Processor seconds of edits of the scene during the present call into the script."""

    def gives_way(self, call_time: float) -> bool:
        """Return whether a call by the thread switches; to be called once for each. `call_time`: seconds that one
        counts as.
        """
        self.called += call_time
        return not self.level and self.called > (_LAST_CALLS if self.is_last else self.seconds)

    def is_tired(self, seconds: float) -> bool:
        """Return whether a thread switches within a loop. `seconds`: time that its iterations since the resumption
        count as.
        """
        return not self.level and seconds > (_LAST_SECONDS if self.is_last else self.seconds)


class Api(Protocol):
    """The server as a script sees it: the namespaces ``sim``, ``simIK`` ... with functions and constants."""

    switching: Switching

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        """Return for each namespace (``sim``) its constants by name, and every function's name with None.

        All entries of ``sim`` also exist as globals with their old names: ``simGetObjectPosition``.
        """
        ...

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        """Call one function by its full name (``sim.getObjectPosition``) with plain values.

        Raises:
            CommandError: with a text for the script's author that does not name the function; the interpreter
                adds script,
                line and function. For an unknown name the text says so and lists similar names.
        """
        ...

    def function(self, name: str) -> Callable[[Sequence[Any]], tuple[Any, ...] | Waiting]:
        """Return a function of the API for many calls with plain values; each is an `invoke` with this name.

        It raises nothing itself: the calls of an unknown name fail.
        """
        ...

    def count_calls(self, count: int) -> None:
        """Note calls of functions that an interpreter has calculated itself, without a call of Python."""
        ...

    def module(self, name: str) -> bytes | None:
        """Return the source text of module ``name`` for ``require`` or ``import``: a file beside the scene, or one of
        the simulator's own; None: no such module.

        Namespaces are not modules. The language is that of the script.

        Raises:
            CommandError: the module is refused.
        """
        ...

    def phases_changed(self) -> None:
        """Note that `Interpreter.lacking` has changed."""
        ...

    def serve_others(self) -> None:
        """Process the requests of other clients; return immediately when there are none.

        It never calls a script and never edits, starts, stops or steps the scene.
        """
        ...

    @property
    def is_ending(self) -> bool:
        """Return whether the server is shutting down; a script may delay this for `ENDING_LIMIT` at most."""
        ...

    def output(self, text: str) -> None:
        """Print a line of the script."""
        ...


class Interpreter(Protocol):
    """One running script. Created as ``Class(name, api, time_limit=seconds)``; `name` is for messages.

    Each method raises ScriptError when the script fails: ``name:line: the reason``; also when it exceeded its time,
    instruction or memory limit. The interpreter stays usable after an error unless the text says otherwise.
    """

    name: str
    lacking: frozenset[str]
    """Those of `PHASES` that surely do not exist now; empty where that is not known."""

    def run(self, source: bytes) -> None:
        """Execute the script's text, which defines its functions; to be called once, before all else."""
        ...

    def has(self, function: str) -> bool:
        """Return whether a function of this name exists; dots select members of tables (objects, modules)."""
        ...

    def call(self, function: str, *arguments: Any) -> list[Any]:
        """Call a function with plain values and return all its results as plain values.

        A function of Python returns a list of one value, of several when it returns a tuple, of none for None. May be
        called while another call of the same script runs (a function of the API that calls back).
        """
        ...

    def attempt(self, function: str, *arguments: Any) -> list[Any] | None:
        """Call a function as `call` does if it exists; return None if not. Its name has no dots."""
        ...

    def evaluate(self, source: bytes) -> list[Any]:
        """Execute a piece of text among the script's variables; return its results: those of `return` in Lua, in
        Python the value of a text that is an expression.
        """
        ...

    def start_thread(self, function: str) -> None:
        """Make this function the script's thread; the first `resume` starts it. Replaces an earlier thread."""
        ...

    def resume(self) -> bool:
        """Run the thread until it waits; return True while it is running, False without a thread."""
        ...

    def close(self) -> None:
        """Free all resources. The object is not used afterwards; closing again has no effect."""
        ...


def refusal(function: str, problem: CommandError) -> str:
    """Return why a function of the API failed; of nested calls with the same error only the outermost one is named."""
    return f"{function}: {str(problem).rpartition(f': {function}: ')[2]}"


def no_such_module(name: str, own: Iterable[str], api: Api) -> str:
    """Return the message for a module that does not exist. `own`: names of the simulator's own modules."""
    return (
        f"there is no such module beside the scene; the simulator's own are {', '.join(api.namespaces())}, "
        f"{', '.join(own)}"
    )
