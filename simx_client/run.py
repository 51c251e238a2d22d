"""``simx-run SCRIPT``: runs an unmodified legacy script and provides what it expects of V-REP's Python.

The provisions are in ``launch``, one file each. This file reads the flags, puts the provisions in place in
the one order that works (patches before the script, the server before its first line) and turns the end into
an exit code.
"""

from __future__ import annotations

import argparse
import ast
import atexit
import logging
import os
import shlex
import signal
import sys
from collections.abc import Sequence
from importlib import metadata
from importlib.util import decode_source
from pathlib import Path
from types import CodeType, FrameType

from simx_client.launch import python2, script
from simx_client.launch.after_import import AfterImport, Patch
from simx_client.launch.bindings import BindingFinder
from simx_client.launch.numpy_aliases import give_back_aliases
from simx_client.launch.paths import BackslashPaths
from simx_client.launch.server import OwnServer, ServerNotReady

PROGRAM = "simx-run"
FAILURE, USAGE, INTERRUPTED = 1, 2, 130

EXAMPLES = """\
what a script gets, in this process only:
  its vrep.py, sim.py, vrepConst.py, simConst.py replaced at import; its own other modules left alone
  np.int and the other names that NumPy dropped
  "folder\\\\file.jpg" read and written as folder/file.jpg, on systems where \\ is no separator

examples:
  simx-run robotControl.py                      a simx-server is running already
  simx-run --server scene.xml robotControl.py   with a server of its own
  simx-run --plain script.py --episodes 10      what follows SCRIPT is the script's
"""


def make_parser() -> argparse.ArgumentParser:
    """The flags come before SCRIPT; all that follows it belongs to the script."""
    parser = argparse.ArgumentParser(
        PROGRAM,
        usage=f"{PROGRAM} [options] SCRIPT [ARGS...]",
        description="Run a Python script written for V-REP's or CoppeliaSim's legacy remote API, unmodified.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("script", metavar="SCRIPT", help="the Python file")
    parser.add_argument("arguments", metavar="ARGS", nargs=argparse.REMAINDER, help="its own arguments")
    parser.add_argument(
        "--server", metavar="SCENE", help="start a simx-server for the script, and stop it after"
    )
    parser.add_argument("--server-args", metavar="ARGS", default="", help='more for it: "--speed max"')
    parser.add_argument(
        "--server-timeout", metavar="S", type=float, default=60.0, help="wait so long until it is ready (60)"
    )
    parser.add_argument("--no-path-translation", action="store_true", help="leave backslashes in paths")
    parser.add_argument("--no-numpy-aliases", action="store_true", help="leave NumPy as it is")
    parser.add_argument("--plain", action="store_true", help="both: only the imports are replaced")
    parser.add_argument("-v", "--verbose", action="store_true", help="say what is replaced")
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {_version()}")
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code, or lets the script's own SystemExit pass.

    As `python SCRIPT` would: 1 after an uncaught exception. 2 for a script that cannot be opened or is
    Python 2, 130 after Ctrl-C.
    """
    options = make_parser().parse_args(argv)
    if options.verbose:
        _log_to_stderr()
    path = os.path.abspath(options.script)
    try:
        source = Path(path).read_bytes()
    except OSError as error:
        return _refuse(f"cannot open {options.script}: {error.strerror}; name the script's .py file", USAGE)
    try:
        code = _compile(source, path)
    except _IsPython2 as refusal:
        return _refuse(str(refusal), USAGE)
    except (SyntaxError, ValueError) as error:  # ValueError: a NUL in the source
        script.show(error.with_traceback(None))
        return FAILURE
    _provide(options, script_folder=os.path.dirname(os.path.realpath(path)))
    if options.server:
        try:
            _start_server(options)
        except ServerNotReady as error:
            return _refuse(str(error), FAILURE)
    try:
        script.run_as_main(code, options.script, options.arguments)
    except SystemExit:
        raise
    except KeyboardInterrupt as error:
        script.show(error)
        return INTERRUPTED
    except BaseException as error:
        if isinstance(error, SyntaxError) and (refusal := _python2_in_a_module(error)):
            return _refuse(str(refusal), USAGE)
        script.show(error)
        return FAILURE
    return 0


class _IsPython2(Exception):
    """The whole sentence for the user."""

    def __init__(self, path: str, finding: python2.Finding) -> None:
        version = ".".join(map(str, sys.version_info[:2]))
        super().__init__(
            f"{path}, line {finding.line}, is Python 2 ({finding.construct}) and this is Python {version}; "
            "convert the script, for example with 2to3, and run it again"
        )


def _compile(source: bytes, path: str) -> CodeType:
    try:
        tree = ast.parse(source, path)
        finding = python2.from_names(tree, decode_source(source))
    except SyntaxError as error:
        finding = python2.from_syntax_error(error, source.decode(errors="replace"))
        if finding is None:
            raise
        raise _IsPython2(path, finding) from None
    if finding is not None:
        raise _IsPython2(path, finding)
    return compile(tree, path, "exec", dont_inherit=True)


def _python2_in_a_module(error: SyntaxError) -> _IsPython2 | None:
    """Why a module that the script imports does not compile, if it is Python 2."""
    if error.filename is None or not os.path.isfile(error.filename):
        return None
    source = Path(error.filename).read_text(encoding="utf-8", errors="replace")
    finding = python2.from_syntax_error(error, source)
    return _IsPython2(error.filename, finding) if finding else None


def _provide(options: argparse.Namespace, script_folder: str) -> None:
    patches: dict[str, Patch] = {}
    if not (options.plain or options.no_numpy_aliases):
        patches["numpy"] = give_back_aliases
    if os.name == "posix" and not (options.plain or options.no_path_translation):
        paths = BackslashPaths(script_folder)
        paths.install()
        patches |= {"cv2": paths.patch_cv2, "pygame.image": paths.patch_pygame_image}
    AfterImport(patches).install()
    sys.meta_path.insert(0, BindingFinder())


def _start_server(options: argparse.Namespace) -> None:
    server = OwnServer(options.server, shlex.split(options.server_args))
    # Registered before the script registers anything, so it runs last: after the script's threads and its own
    # exit functions, which may still want to talk to the server.
    atexit.register(server.stop)

    def stop_too(number: int, frame: FrameType | None) -> None:
        server.stop()
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)

    signal.signal(signal.SIGTERM, stop_too)
    server.start(options.server_timeout)


def _refuse(sentence: str, code: int) -> int:
    sys.stderr.write(f"{PROGRAM}: {sentence}\n")
    return code


def _log_to_stderr() -> None:
    """Our own log only: the root logger is the script's to configure."""
    log = logging.getLogger("simx_client")
    log.addHandler(logging.StreamHandler())
    log.setLevel(logging.INFO)
    log.propagate = False


def _version() -> str:
    try:
        return metadata.version("simx-vrep")
    except metadata.PackageNotFoundError:
        return "(not installed)"


if __name__ == "__main__":
    sys.exit(main())
