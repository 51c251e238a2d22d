"""Build the walls around the process of a Python script, then run the interpreter within them.

`process.py` starts this file; it turns into `python_child.py`. So the interpreter that runs the script has all walls
from its start: neither ctypes nor anything else that built them was ever loaded there.

Arguments: the number of the lifeline; whether seccomp is required (1) or not (0); the folder that the script may read
(empty: none); the folders of Python's library and the installed packages.
"""

from __future__ import annotations

import fcntl
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # isolated Python leaves it out

import python_confine
import python_limits

_SIGKILL = 9  # the module signal makes classes for all of them


def main() -> None:
    """Prepare descriptors and limits, confine the process, and execute the script's interpreter."""
    lifeline, needs_filter, folder, *libraries = sys.argv[1:]
    end_with(int(lifeline))
    reading, writing = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    # The server reads standard error only after this process has ended: a full pipe must not stop the script.
    os.set_blocking(2, False)
    for place in (reading, writing):
        os.set_inheritable(place, True)
    own = os.path.dirname(os.path.abspath(__file__))
    shared = python_confine.mapped_files()
    readable = [*libraries, f"{sys.base_prefix}/lib", own, *virtual_environment()]
    if folder:
        readable.append(folder)
    python_confine.limit_resources()
    missing = python_confine.missing()
    if "seccomp" in missing and int(needs_filter):
        _refuse(
            "this kernel or container has no seccomp, so nothing would confine it against its author's will; write it "
            "in Lua, or start the server with --unconfined-scripts"
        )
    child = os.path.join(own, "python_child.py")
    command = [sys.executable, "-s", "-S", "-B", child, str(reading), str(writing), ",".join(missing)]
    try:
        python_confine.run(
            os.path.realpath("/proc/self/exe"), [*command, *libraries], readable, shared, int(lifeline)
        )
    except OSError as problem:
        _refuse(f"it cannot be confined: {problem}")


def end_with(lifeline: int) -> None:
    """Have the kernel kill this process when the other end of this pipe closes, whatever the script is doing then."""
    fcntl.fcntl(lifeline, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(lifeline, fcntl.F_SETSIG, _SIGKILL)
    fcntl.fcntl(lifeline, fcntl.F_SETFL, fcntl.fcntl(lifeline, fcntl.F_GETFL) | os.O_ASYNC)


def virtual_environment() -> list[str]:
    """Return the file by which the interpreter finds its library, if it has one."""
    folder = os.path.dirname(sys.executable)
    return [os.path.join(place, "pyvenv.cfg") for place in (folder, os.path.dirname(folder))]


def _refuse(why: str) -> None:
    print(why, file=sys.stderr, flush=True)
    os._exit(python_limits.NOT_CONFINED)


if __name__ == "__main__":
    main()
