"""The tools of ``simx mcp``, by the protocol's official library: the methods of a session, with their docstrings."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import Any

from mcp.server import MCPServer
from mcp.server.mcpserver import Image
from mcp.server.mcpserver.exceptions import ToolError

from simx_client.errors import SimxError
from simx_client.protocol.version import __version__

from .session import Session

INSTRUCTIONS = """\
A robot simulation in the terms of V-REP and CoppeliaSim, on MuJoCo. Objects have names and handles; units: m, rad, s.
Load a scene, look at its tree, then step: time passes in steps only. `call` calls any function of the legacy remote
API; `functions` finds them. Names stand for handles. Every step is kept: `past` shows it, `go_on_from` starts a new
run from it.
"""


def make_server(session: Session) -> MCPServer:
    """Return the server with the tools of a session; those that run code only if the session allows it."""
    server: MCPServer = MCPServer("simx", version=__version__, instructions=INSTRUCTIONS)
    lock = threading.Lock()
    tools: list[Callable[..., str | bytes]] = [
        session.load, session.tree, session.step, session.call, session.functions, session.image,
        session.past, session.go_on_from, session.replay, session.check,
    ]  # fmt: skip
    if session.allows_code:
        tools += [session.run, session.compare]
    for tool in tools:
        server.add_tool(_in_turn(tool, lock), structured_output=False)
    return server


def _in_turn(method: Callable[..., str | bytes], lock: threading.Lock) -> Callable[..., Any]:
    """Return a method as a tool: one at a time; the text of an error is for the agent; bytes are a PNG."""

    @functools.wraps(method)
    def tool(*values: Any, **named: Any) -> str | Image:
        with lock:
            try:
                result = method(*values, **named)
            except (SimxError, ValueError) as error:
                raise ToolError(str(error)) from None
        return result if isinstance(result, str) else Image(data=result, format="png")

    return tool
