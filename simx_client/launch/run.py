"""Implement ``simx-run SCRIPT``: run an unmodified legacy script with the adaptations in ``launch``.

This file reads the flags, applies the adaptations in the order that works (patches before the script, the
server before its first line) and converts the end into an exit code.
"""

from __future__ import annotations

import argparse
import atexit
import logging
import os
import shlex
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, FrameType

from simx_client.connection.embedding import VARIABLE as EMBED_VARIABLE
from simx_client.connection.pace import OLD_SCRIPTS, PACES, VARIABLE
from simx_client.old_python.convert import Converted, decode
from simx_client.old_python.loading import IsPython2, Python2Finder, convert_if_python2
from simx_client.protocol.cli.exit_codes import DONE, FAILURE, INTERRUPTED, USAGE
from simx_client.protocol.cli.parser import Parser, seconds
from simx_client.protocol.files import scene_for
from simx_client.protocol.nearest import file_like

from . import script
from .after_import import AfterImport, Patch, in_turn
from .bindings import BindingFinder
from .hints import hint, misplaced_flags, no_script
from .model_clients import ModelPackage, send_models_to, uses_model
from .own_library import OwnLibraryFinder
from .paths import BackslashPaths
from .pyrep import pyrep_root, stand_in_for_pyrep
from .restoring.libraries import LIBRARIES
from .restoring.matplotlib_aliases import MATPLOTLIB
from .restoring.numpy_arrays import NUMPY
from .restoring.python_aliases import ALIASES
from .server import OwnServer, ServerNotReady
from .windows.patch import patch_cv2
from .zmq_clients import OldName, send_clients_to, uses_zmq

PROGRAM = "simx-run"

EXAMPLES = """\
what a script gets, in this process only:
  its vrep.py, sim.py, vrepConst.py, simConst.py replaced at import; its own other modules left alone
  Python 2 converted, in memory: the script, and its own modules where it imports them
  np.int, float(array of one), fig.gca(projection='3d'), time.clock and what else NumPy, matplotlib,
    SciPy, Pillow and Python dropped
  cv2.imshow, waitKey and the like, where OpenCV was installed without windows (opencv-python-headless)
  "folder\\\\file.jpg" read and written as folder/file.jpg, on systems where \\ is no separator

examples:
  simx-run robotControl.py                      a simx-server is running already
  simx-run --server scene.ttt robotControl.py   with a server of its own
  simx-run --embed scene.ttt robotControl.py    the same in one process: calls take microseconds
  simx-run --pyrep reach.py                     a program of PyRep: it opens its scenes itself
"""


def make_parser() -> Parser:
    """Return the parser. The flags come before SCRIPT; all arguments after it belong to the script."""
    parser = Parser(
        PROGRAM,
        usage=f"{PROGRAM} [options] SCRIPT [ARGS...]",
        description="Run a Python script written for V-REP's or CoppeliaSim's legacy remote API, or PyRep, unmodified.",
        epilog=EXAMPLES,
    )
    parser.add_argument("script", metavar="SCRIPT", nargs="?", help="the Python file")
    parser.add_argument("arguments", metavar="ARGS", nargs=argparse.REMAINDER, help="arguments of the script")
    parser.add_argument(
        "--server", metavar="SCENE", help="start a simx-server for the script, and stop it after"
    )
    parser.add_argument(
        "--embed", metavar="SCENE", help="simulate in the script's own process, without a server"
    )
    parser.add_argument("--pyrep", action="store_true", help="a program of PyRep, without CoppeliaSim")
    parser.add_argument(
        "--pyrep-root",
        action="store_true",
        help="print a COPPELIASIM_ROOT to install PyRep, and exit",
    )
    parser.add_argument(
        "--legacy",
        metavar="PORT",
        type=int,
        help="the script's own library connects to this port",
    )
    parser.add_argument(
        "--zmq", metavar="PORT", type=int, help="the script's ZeroMQ clients connect to this port"
    )
    parser.add_argument("--server-args", metavar="ARGS", default="", help='more for all three: "--speed max"')
    parser.add_argument(
        "--server-timeout",
        metavar="S",
        type=seconds,
        default=60.0,
        help="wait so long until it is ready (60)",
    )
    parser.add_argument(
        "--pace",
        choices=tuple(PACES),
        help="blocking calls during a run; free: executed at once; repeat: a call that repeats one of the same step "
        f"waits for the next step; every: each waits ({OLD_SCRIPTS})",
    )
    parser.add_argument(
        "--no-path-translation", action="store_true", help="do not translate backslashes in paths"
    )
    parser.add_argument(
        "--no-numpy-aliases", action="store_true", help="do not patch NumPy, matplotlib, SciPy, Pillow"
    )
    parser.add_argument(
        "--no-windows", action="store_true", help="leave cv2 without windows where it has none"
    )
    parser.add_argument(
        "--plain", action="store_true", help="all three, and leave Python's modules as they are"
    )
    parser.add_argument(
        "--print-converted",
        action="store_true",
        help="print a Python 2 script as Python 3, and do not run it",
    )
    parser.add_argument("-v", "--verbose", action="store_true", help="say what is replaced")
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code, or let the script's SystemExit pass.

    As `python SCRIPT`: 1 after an uncaught exception. 2 for a script that cannot be opened or is Python 2
    that cannot be converted, 130 after Ctrl-C.
    """
    parser = make_parser()
    options = parser.parse_args(argv)
    if options.verbose:
        _log_to_stderr()
    if options.pyrep_root:
        print(pyrep_root())
        return DONE
    if problem := no_script(options.script):
        return _refuse(problem, USAGE)
    path = os.path.abspath(options.script)
    try:
        source = Path(path).read_bytes()
    except OSError as error:
        return _refuse(_why_not_opened(options.script, error), USAGE)
    try:
        converted = convert_if_python2(source, path)
        if options.print_converted:
            return _print(source, converted)
        code = converted.code if converted else compile(source, path, "exec", dont_inherit=True)
    except IsPython2 as refusal:
        return _refuse(str(refusal), USAGE)
    except (SyntaxError, ValueError) as error:  # ValueError: a NUL in the source
        script.show(error.with_traceback(None))
        return FAILURE
    for flag in misplaced_flags(options.arguments, parser.flags, source):
        _say(
            f"{flag} behind the script goes to the script; write it in front: {PROGRAM} {flag} ... {options.script}"
        )
    _prepare(options, path, is_python2=converted is not None)
    if conflict := _conflict(options):
        return _refuse(conflict, USAGE)
    try:
        _simulate(options)
    except ServerNotReady as error:
        return _refuse(str(error), FAILURE)
    return _run(code, options.script, options.arguments)


def _conflict(options: argparse.Namespace) -> str:
    """Return which flags exclude each other, or an empty text."""
    if options.embed and options.server:
        return "--server and --embed exclude each other; give one of them"
    if options.legacy is not None and (options.embed or options.server or options.pyrep):
        return "--legacy names a port that is served already: leave out --server, --embed and --pyrep"
    if options.pyrep and (options.embed or options.server):
        return "a program of PyRep opens its scene itself: leave out --server and --embed"
    return ""


def _simulate(options: argparse.Namespace) -> None:
    """Provide the simulation that the flags ask for. Raises ServerNotReady."""
    if options.pyrep:
        stand_in_for_pyrep(options.server_args)
    if options.zmq is not None:
        send_clients_to(options.zmq)
    if options.embed:
        scene = scene_for(Path(options.script), options.embed)
        os.environ[EMBED_VARIABLE] = shlex.join([scene, *shlex.split(options.server_args)])
    if options.server:
        _start_server(options)


def _why_not_opened(script: str, error: OSError) -> str:
    """Return what to write in place of a script that cannot be opened."""
    meant = file_like(script, (".py",)) or ";"
    told = f"cannot open {script}: {error.strerror}{meant} name the script's .py file"
    if os.path.splitext(script)[1]:
        return told
    return f"{told}, or, if it is a scene: simx-run --server {script} SCRIPT"


def _prepare(options: argparse.Namespace, path: str, *, is_python2: bool) -> None:
    """Set the pace and install the adaptations for a script."""
    if is_python2:
        _say(f"{options.script} is Python 2 and runs converted, in memory; --print-converted shows how")
    if options.pace:
        os.environ[VARIABLE] = options.pace
    if not os.environ.get(VARIABLE, "").strip():
        os.environ[VARIABLE] = OLD_SCRIPTS
    _provide(options, os.path.dirname(os.path.realpath(path)), is_python2=is_python2)


def _run(code: CodeType, path: str, arguments: Sequence[str]) -> int:
    """Run the script; return the exit code, or let its SystemExit pass."""
    try:
        script.run_as_main(code, path, arguments)
    except SystemExit:
        raise
    except KeyboardInterrupt as error:
        script.show(error)
        return INTERRUPTED
    except BaseException as error:
        if isinstance(error, IsPython2):
            return _refuse(str(error), USAGE)
        script.show(error)
        if sentence := hint(error):
            _say(sentence)
        return FAILURE
    return DONE


def _provide(options: argparse.Namespace, script_folder: str, *, is_python2: bool) -> None:
    patches: dict[str, Patch] = {} if options.plain else dict(ALIASES)
    if not (options.plain or options.no_numpy_aliases):
        patches |= {**NUMPY, **MATPLOTLIB, **LIBRARIES}
    if os.name == "posix" and not (options.plain or options.no_path_translation):
        paths = BackslashPaths(script_folder)
        paths.install()
        patches |= {"cv2": paths.patch_cv2, "pygame.image": paths.patch_pygame_image}
    if not (options.plain or options.no_windows):
        patches["cv2"] = in_turn(*filter(None, (patches.get("cv2"), patch_cv2)))
    # Bindings first, so that a carried binding is never executed; conversion last, so that the other two find
    # its result.
    sys.meta_path.insert(0, Python2Finder(script_is_python2=is_python2))
    AfterImport(patches).install()
    if options.legacy is None:
        sys.meta_path.insert(0, BindingFinder())
    else:
        OwnLibraryFinder(options.legacy).install()
    OldName().install()
    if uses_model(Path(options.script)):
        ModelPackage().install()


def _start_server(options: argparse.Namespace) -> None:
    script_path = Path(options.script)
    scene = scene_for(script_path, options.server)
    server = OwnServer(
        scene,
        shlex.split(options.server_args),
        with_zmq=uses_zmq(script_path),
        with_model=uses_model(script_path),
    )
    # Registered before the script registers anything, so it runs last: after the script's threads and its
    # exit functions, which may still call the server.
    atexit.register(server.stop)

    def stop_too(number: int, frame: FrameType | None) -> None:
        server.stop()
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)

    # With SIGHUP ignored, as nohup does, the run continues without its terminal.
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, stop_too)
    server.start(options.server_timeout)
    if server.zmq_port is not None:
        send_clients_to(server.zmq_port)
    if server.model_port is not None:
        send_models_to(server.model_port)


def _print(source: bytes, converted: Converted | None) -> int:
    if converted is None:
        _say("this is no Python 2; the text is printed as it is")
    sys.stdout.write(converted.text if converted else decode(source))
    return DONE


def _refuse(sentence: str, code: int) -> int:
    _say(sentence)
    return code


def _say(sentence: str) -> None:
    sys.stderr.write(f"{PROGRAM}: {sentence}\n")


def _log_to_stderr() -> None:
    """Log this package to stderr; the script configures the root logger."""
    log = logging.getLogger("simx_client")
    log.addHandler(logging.StreamHandler())
    log.setLevel(logging.INFO)
    log.propagate = False


if __name__ == "__main__":
    sys.exit(main())
