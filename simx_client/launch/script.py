"""Run a file as ``__main__`` as ``python FILE ARGS`` does: names, arguments, tracebacks, exit code."""

from __future__ import annotations

import builtins
import os
import sys
from collections.abc import Sequence
from importlib.machinery import SourceFileLoader
from types import CodeType, ModuleType, TracebackType

_OUR_FOLDER = os.path.dirname(os.path.abspath(__file__))
_OUR_FILES = {os.path.join(os.path.dirname(_OUR_FOLDER), "python2.py")}


def run_as_main(code: CodeType, path: str, arguments: Sequence[str]) -> None:
    """Run the code; its exceptions pass. `path` is the file as named on the command line."""
    module = ModuleType("__main__")
    module.__dict__.update(
        __builtins__=builtins,
        __file__=os.path.abspath(path),
        __cached__=None,
        __annotations__={},
        __loader__=SourceFileLoader("__main__", os.path.abspath(path)),
    )
    sys.modules["__main__"] = module
    sys.argv[:] = [path, *arguments]
    if not sys.flags.safe_path:
        sys.path[0] = os.path.dirname(os.path.realpath(path))
    exec(code, module.__dict__)


def show(error: BaseException) -> None:
    """Print an uncaught exception as Python does, without the launcher's frames."""
    _hide_our_frames(error, set())
    sys.excepthook(type(error), error, error.__traceback__)


def _hide_our_frames(error: BaseException, seen: set[int]) -> None:
    if id(error) in seen:
        return
    seen.add(id(error))
    error.__traceback__ = _without_our_frames(error.__traceback__)
    for other in (error.__cause__, error.__context__):
        if other is not None:
            _hide_our_frames(other, seen)


def _without_our_frames(traceback: TracebackType | None) -> TracebackType | None:
    if traceback is None:
        return None
    rest = _without_our_frames(traceback.tb_next)
    filename = traceback.tb_frame.f_code.co_filename
    if filename in _OUR_FILES or os.path.dirname(filename) == _OUR_FOLDER:
        return rest
    traceback.tb_next = rest
    return traceback
