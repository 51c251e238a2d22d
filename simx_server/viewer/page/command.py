"""The page's process: ``simx-server --view`` starts one, and people do to look at a server that runs already."""

from __future__ import annotations

import argparse
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from types import FrameType
from typing import TYPE_CHECKING

from simx_client.protocol.exit_codes import DONE, FAILURE, INTERRUPTED
from simx_server import log_format
from simx_server.setting_rules import web_address
from simx_server.settings import LOG_LEVELS
from simx_server.viewer.launching import missing
from simx_server.viewer.messages import OWN_NAME

from .gate import Gate

if TYPE_CHECKING:
    from .composition import Page

logger = logging.getLogger(__name__)

PROGRAM = "python -m simx_server.viewer"
EXAMPLES = f"""\
examples:
  {PROGRAM}                        the server at 127.0.0.1:19997, on http://127.0.0.1:8080/
  {PROGRAM} 127.0.0.1:20000 --at 8081
  {PROGRAM} lab-3@router:7447      a server by its realm, behind a router
  {PROGRAM} --at 0.0.0.0:8080      for others, too, with a token
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Serve a page until interrupted. Returns the exit code."""
    options = _parser().parse_args(argv)
    log_format.configure(options.log_level, options.log_format, several=False)
    if problem := missing():
        logger.error("%s", problem)
        return FAILURE
    sys.argv[0] = OWN_NAME  # what the server knows this process's clients by
    from .composition import Page
    from .quiet_viser import open_browser_server

    with ExitStack() as stack:
        browser = open_browser_server()
        stack.callback(browser.stop)
        host, _, port = options.at.rpartition(":")
        try:
            gate = Gate(host.strip("[]"), int(port), browser.get_port())
        except OSError as error:
            logger.error(
                "no page at %s: %s; choose another port with --at, or 0 for a free one", options.at, error
            )
            return FAILURE
        stack.callback(gate.close)
        page = Page(browser, options.server)
        stack.callback(page.close)
        code = _ended_by(page, until_eof=options.until_eof)
        sys.stdout.write(f"page {gate.url}\n")
        sys.stdout.flush()
        page.run()
    return code()


def _ended_by(page: Page, *, until_eof: bool) -> Callable[[], int]:
    """Let the page be ended by SIGINT or SIGTERM, or by the end of stdin. Gives what tells the exit code then."""
    has_come: list[int] = []

    def on_signal(number: int, frame: FrameType | None) -> None:
        has_come.append(number)
        page.end()

    signal.signal(signal.SIGTERM, on_signal)
    if until_eof:
        # Ctrl-C in a terminal reaches this process as well; the server ends it, once it has stopped itself.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        threading.Thread(target=_end_at_eof, args=(page,), name="simx-eof", daemon=True).start()
    else:
        signal.signal(signal.SIGINT, on_signal)
    return lambda: INTERRUPTED if has_come else DONE


def _end_at_eof(page: Page) -> None:
    while os.read(sys.stdin.fileno(), 4096):
        pass
    page.end()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        PROGRAM,
        description="A page in the browser that shows a running server and has it operated.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
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
        "--log-level", choices=LOG_LEVELS, default="warning", help="how much to tell (warning)"
    )
    parser.add_argument(
        "--log-format", choices=log_format.FORMATS, default="text", help="for people or programs"
    )
    parser.add_argument("--until-eof", action="store_true", help="end when stdin is closed, not by Ctrl-C")
    return parser


def _address(text: str) -> str:
    try:
        return web_address(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} cannot be used; valid: a port, 0 for a free one, or HOST:PORT"
        ) from None
