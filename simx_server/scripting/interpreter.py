"""What an embedded script's language must offer the server, and what the server offers it.

`lua.py` and `python_interpreter.py` are the two languages. A script has one interpreter for its life; only the physics
thread uses it.

Values cross the border as plain Python ones: None, bool, int, float, bytes (every string, whatever it holds), list,
dict (keys str or int) and `Function`; nested as deeply as `MAX_DEPTH`. Results of a call
are a list; a function of the API returns a tuple of results. What cannot cross is a ScriptError.

**Threads.** A script has at most one thread of the server's (``sysCall_thread`` or ``sysCall_threadmain``), a coroutine
that runs only within `Interpreter.resume`, which is called once per pass. A function of the API that must wait is a
generator on the server's side: `Api.invoke` returns it instead of results, each of its yields means "until the
next pass", what it returns is the tuple of results. The interpreter advances it once at once, and if it yields, once at
each further resumption of the coroutine that called; exceptions of it are those of the call. Outside a coroutine
such a call is refused with `NOT_IN_A_THREAD` before the generator is advanced. Beside this, a call of the API made in
a thread, that is over `Switching.seconds` after the thread's resumption, counted in calls and not by a clock so that
runs can be repeated bit for bit, gives way by itself (waits for
the next resumption, then returns its results), unless `Switching.level` is above 0. So does a loop of the thread, also
one without calls, after so many turns since the resumption; where Lua cannot yield (in a function that a function in C
calls, as ``table.sort`` does) the loop goes on.

**Others are served.** While a call into a script runs longer than `PATIENCE`, the interpreter calls `Api.serve_others`
every few milliseconds, from the physics thread and from a place where the script holds no lock. Time spent there does
not count against the script's processor time; a Python script, whose process runs beside, also has an end by the wall.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from ..errors import CommandError

TIME_LIMIT = 2.0
"""Processor seconds that one call into a script may take; well below the 5 s a blocking client waits."""

MEMORY_LIMIT = 64 << 20
"""Bytes that one script may hold."""

ENDING_LIMIT = 1.0
"""Seconds by the wall that a call into a script may take, also one to its cleanup, once the server is to end."""

PATIENCE = 0.003
"""Seconds that a script may run before other clients are served in between, and between two times of that."""

MAX_DEPTH = 16
"""Tables within tables that may cross the border; deeper, and endless ones, are an error."""

NOT_IN_A_THREAD = (
    "waits, so it works only in a thread: sysCall_thread, a threaded script, or a script's coroutine"
)

Constant = int | float | bool | str | dict[str, int]
"""Of a namespace; a dict is a table of constants, as ``simOMPL.Algorithm``."""

Waiting = Generator[None, None, tuple[Any, ...]]
"""A function of the API that is not over yet: a yield is a pass, what it returns are the results."""


class ScriptError(CommandError):
    """A script failed, or cannot be called: the text says which script, where and why."""


@runtime_checkable
class Function(Protocol):
    """A function of a script that it handed out; handed back to the same script it is the function itself.

    After the script's end a call is a ScriptError.
    """

    def __call__(self, *arguments: Any) -> list[Any]:
        """Call it with plain values; all its results. Raises ScriptError."""
        ...


Plain = None | bool | int | float | bytes | str | list[Any] | tuple[Any, ...] | dict[Any, Any] | Function
"""A value that crosses the border; the server may also give a str for a string and a tuple for a list."""

_LAST_SECONDS = 0.02
"""For the turns of loops in a thread's last resumption, where one that waits for something would wait in vain."""


@dataclass(slots=True)
class Switching:
    """When the thread of a script gives way by itself. The API's functions change it, the interpreter obeys."""

    level: int = 0
    """Above 0 only a function that waits gives way."""

    seconds: float = 0.002
    """Time after a resumption at whose end the next call of the API gives way; V-REP's default."""

    is_last: bool = False
    """The run ends and the thread is resumed for the last time: what it does after its loop is not to be cut short."""

    calls: int = 0
    """Of the API by the thread, since its resumption."""

    spent: float = 0.0
    """Processor seconds that functions of the API with limits of their own took in the present call into the script."""

    def gives_way(self, call_time: float) -> bool:
        """Whether a call by the thread does so; to be asked once for each. `call_time`: seconds that one counts for."""
        self.calls += 1
        return not self.level and not self.is_last and self.calls * call_time > self.seconds

    def is_tired(self, seconds: float) -> bool:
        """Whether a thread gives way within a loop. `seconds`: what its turns since the resumption count for."""
        return not self.level and seconds > (_LAST_SECONDS if self.is_last else self.seconds)


class Api(Protocol):
    """What a script finds: the namespaces ``sim``, ``simIK`` ... with functions and constants."""

    switching: Switching

    def namespaces(self) -> Mapping[str, Mapping[str, Constant | None]]:
        """Per namespace (``sim``) its constants by name, and every function's name with None.

        Of ``sim`` everything also exists as a global by its old name, see `flat_name`.
        """
        ...

    def invoke(self, name: str, arguments: list[Any]) -> tuple[Any, ...] | Waiting:
        """Call one function by its full name (``sim.getObjectPosition``) with plain values.

        Raises CommandError with a text for the script's author that does not name the function; the interpreter
        puts script, line and function in front. For a name that is not known the text says so and what is near.
        """
        ...

    def module(self, name: str) -> bytes | None:
        """Source text of what ``require 'name'`` (``import name``) means beside the scene; None: no such file.

        Namespaces are not among these. The language is the script's own. Raises CommandError for a refused one.
        """
        ...

    def serve_others(self) -> None:
        """Deal with what other clients have sent meanwhile; does nothing, quickly, when there is nothing.

        It never calls a script and never edits, starts, stops or steps the scene.
        """
        ...

    @property
    def is_ending(self) -> bool:
        """The server has been told to end, which a script may hold up for `ENDING_LIMIT` at most."""
        ...

    def output(self, text: str) -> None:
        """What the script prints."""
        ...


class Interpreter(Protocol):
    """One running script. Made as ``Class(name, api, time_limit=seconds)``; `name` is for messages.

    Each of these raises ScriptError when the script does: ``name:line: what went wrong``; also when it ran over its
    time, instruction or memory limit. The interpreter stays usable after an error unless the text says otherwise.
    """

    name: str

    def run(self, source: bytes) -> None:
        """Execute the script's text, which defines its functions; to be called once, first."""
        ...

    def has(self, function: str) -> bool:
        """Whether a function of this name exists; dots reach into tables (objects, modules)."""
        ...

    def call(self, function: str, *arguments: Any) -> list[Any]:
        """Call a function with plain values; all its results as plain values.

        A function of Python returns a list of one value, of several when it returns a tuple, of none for None.
        May be called while another call of the same script runs (a function of the API that calls back).
        """
        ...

    def start_thread(self, function: str) -> None:
        """Make this function the script's thread; it begins with the first `resume`. Replaces an earlier thread."""
        ...

    def resume(self) -> bool:
        """Let the thread go on until it waits; True while it is still alive (False too without a thread)."""
        ...

    def close(self) -> None:
        """Free everything. The object is not used afterwards; closing again does nothing."""
        ...


def refusal(function: str, problem: CommandError) -> str:
    """Why a function of the API failed; of calls that pass the same error on only the outermost one is named."""
    return f"{function}: {str(problem).rpartition(f': {function}: ')[2]}"


def no_such_plugin(name: str, api: Api) -> str:
    """What a script is told that looks for the functions of a plug-in of V-REP's."""
    return (
        f"this server has no plug-in {name}; namespaces that scripts find are {', '.join(api.namespaces())}"
    )


def flat_name(name: str, *, is_function: bool) -> str:
    """The old name of something of ``sim``: ``getObjectPosition`` is ``simGetObjectPosition``, ``handle_self``
    is ``sim_handle_self``."""
    return f"sim{name[:1].upper()}{name[1:]}" if is_function else f"sim_{name}"
