"""Every remote function of the table as a method that notes the call instead of making it.

Methods take neither client id nor operation mode: the batch has the id, and a mode has no meaning in it. The
types are in ``calls.pyi``, made from the table by ``python -m simx_client.legacy.stubs``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from simx_client.calls.answers import Answer
from simx_client.calls.marshalling import Marshal
from simx_client.calls.strict import Explained
from simx_client.protocol.commands import TABLE, Command, Place


def is_batched(command: Command) -> bool:
    """Return whether a function can be part of a batch: it is remote and sends no file of the client."""
    return command.place in (Place.REMOTE, Place.WAITING) and not command.loads_file


class Calls(Explained):
    """Calls to one server, in order; each method returns the ``Answer`` to come."""

    __slots__ = ("__weakref__", "_server", "noted", "where")

    def __init__(self, server: int, where: str) -> None:
        """Note calls for one of several servers.

        Args:
            server: index of the server, for messages.
            where: its address, for messages.
        """
        self._server, self.where = server, where
        self.noted: list[Answer[Any]] = []

    def __repr__(self) -> str:
        return f"<Calls to {self.where}: {len(self.noted)} noted>"

    def note(self, marshal: Marshal, arguments: tuple[Any, ...]) -> Answer[Any]:
        """Add one call.

        Raises:
            TypeError, IndexError: an argument is not valid; the text names function and argument.
        """
        answer: Answer[Any] = Answer(marshal, marshal.coerce(arguments), self._server, self.where)
        self.noted.append(answer)
        return answer

    def repeat(self, noted: Sequence[Answer[Any]]) -> None:
        """Add calls to the same server that were noted earlier; their answers are replaced."""
        self.noted += noted


_TEMPLATE = "def {name}(self{parameters}):\n    return self.note(_marshal, ({arguments}))\n"


def _compile(name: str, marshal: Marshal) -> Callable[..., Answer[Any]]:
    names = [argument.name for argument in marshal.command.arguments]
    source = _TEMPLATE.format(
        name=name,
        parameters="".join(f", {each}" for each in names),
        arguments="".join(f"{each}, " for each in names),
    )
    namespace: dict[str, Any] = {"_marshal": marshal}
    exec(
        compile(source, f"<simx_client.connection.calls {name}>", "exec"), namespace
    )  # the text comes from the table, not from input
    function = namespace[name]
    function.__doc__ = marshal.command.doc
    function.__module__, function.__qualname__ = __name__, f"Calls.{name}"
    return function


for _command in TABLE:
    if is_batched(_command):
        _marshal = Marshal(_command)
        for _name in _command.names:
            setattr(Calls, _name, _compile(_name, _marshal))
