"""The web viewer's process: ``simx-server --view`` starts one; users start one for a server that runs already."""

from __future__ import annotations

import argparse
import logging
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from types import FrameType
from typing import TYPE_CHECKING

from simx_client.protocol.cli.exit_codes import DONE, FAILURE, INTERRUPTED
from simx_client.protocol.cli.parser import Parser
from simx_server.processes import log_format
from simx_server.processes.watchdog import watched
from simx_server.settings.rules import web_address
from simx_server.settings.settings import LOG_LEVELS
from simx_server.viewer.launching import listen, missing
from simx_server.viewer.messages import OWN_NAME

from .gate import Gate

if TYPE_CHECKING:
    from .composition import Page

logger = logging.getLogger(__name__)

PROGRAM = "python -m simx_server.viewer"
_CLOSING = 1.0
"""Seconds for a clean end: the viewer may be loading a scene, or wait for an answer."""

_END_TIMEOUT = 2.0
"""Seconds in which the viewer ends after its server; then it is killed."""

EXAMPLES = f"""\
examples:
  {PROGRAM}                        the server at 127.0.0.1:19997, on http://127.0.0.1:8080/
  {PROGRAM} 127.0.0.1:20000 --at 8081
  {PROGRAM} lab-3@router:7447      a server by its realm, behind a router
  {PROGRAM} --at 0.0.0.0:8080      for others, too, with a token
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Serve the web viewer until interrupted. Returns the exit code."""
    options = make_parser().parse_args(argv)
    log_format.configure(options.log_level, options.log_format, several=False)
    if problem := missing():
        logger.error("%s", problem)
        return FAILURE
    try:
        listener = _listener(options)
    except OSError as error:
        logger.error("%s", error)
        return FAILURE
    if options.until_eof:
        for name in ("simx_client", "simx_server.viewer"):  # the server itself reports its end
            logging.getLogger(name).setLevel(logging.ERROR)
    lifeline = sys.stdin.fileno() if options.until_eof else None
    with listener, watched(0, lifeline, _END_TIMEOUT):
        try:
            serve_view(listener, options.server, told=_say, teleop=options.teleop)
        except KeyboardInterrupt:
            return INTERRUPTED
    return DONE


def serve_view(
    listener: socket.socket,
    server: str,
    token: str | None = None,
    told: Callable[[str], object] = lambda _url: None,
    *,
    teleop: str | None = None,
) -> None:
    """Serve the web viewer until a signal ends it.

    Args:
        listener: where browsers come.
        server: ``HOST:PORT``, or ``REALM@HOST:PORT``.
        token: the token to require; None chooses one if other machines can reach `listener`.
        told: called with the address for a browser.
        teleop: the arm to drive, an empty text for the first one; None: none.
    """
    sys.argv[0] = OWN_NAME  # the name by which the server knows this process's clients
    with ExitStack() as stack:
        from simx_server.scene import physics_warnings

        from .composition import Page
        from .quiet_viser import open_browser_server

        physics_warnings.listen()

        browser = open_browser_server()
        stack.callback(browser.stop)
        page = Page(browser, server, teleop)
        stack.callback(page.close)
        gate = Gate(listener, (browser.get_host(), browser.get_port()), token)
        stack.callback(gate.close)
        _ended_by(page)
        told(gate.url)
        page.run()


def _say(url: str) -> None:
    sys.stdout.write(f"page {url}\n")
    sys.stdout.flush()


def _listener(options: argparse.Namespace) -> socket.socket:
    """Return the listening socket. Raises OSError."""
    if options.listener is not None:
        return socket.socket(fileno=options.listener)
    return listen(options.at, "--at")


def _ended_by(page: Page) -> None:
    """End the viewer on SIGINT or SIGTERM; end the process on a second one or when the viewer takes long."""
    has_come = False
    is_told = threading.Event()

    def on_signal(number: int, frame: FrameType | None) -> None:
        nonlocal has_come
        if has_come:  # it waits for an answer, or for a lock that was taken when this signal came
            os._exit(INTERRUPTED)
        has_come = True
        page.end()
        is_told.set()

    def end_late() -> None:
        is_told.wait()
        time.sleep(_CLOSING)
        os._exit(DONE)  # the viewer has no data to lose

    threading.Thread(target=end_late, name="simx-page-end", daemon=True).start()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, on_signal)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser for the flags of the web viewer."""
    parser = Parser(
        PROGRAM,
        description="A web viewer that shows and operates a running server.",
        epilog=EXAMPLES,
    )
    parser.add_argument(
        "server",
        nargs="?",
        default="127.0.0.1:19997",
        metavar="SERVER",
        help="HOST:PORT, or REALM@HOST:PORT (127.0.0.1:19997)",
    )
    parser.add_argument(
        "--at",
        type=_address,
        default="127.0.0.1:8080",
        metavar="PORT",
        help="where browsers find it (8080); HOST:PORT for others too, 0 for a free port",
    )
    parser.add_argument(
        "--teleop",
        nargs="?",
        const="",
        metavar="ARM",
        help="drive an arm by keys, a gamepad and the mouse (the first arm)",
    )
    parser.add_argument(
        "--log-level", choices=LOG_LEVELS, default="warning", help="how much to tell (warning)"
    )
    parser.add_argument(
        "--log-format", choices=log_format.FORMATS, default="text", help="for people or programs"
    )
    parser.add_argument("--until-eof", action="store_true", help="end when stdin is closed, too")
    parser.add_argument("--listener", type=int, metavar="FD", help=argparse.SUPPRESS)
    return parser


def _address(text: str) -> str:
    try:
        return web_address(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} cannot be used; valid: a port, 0 for a free one, or HOST:PORT"
        ) from None
