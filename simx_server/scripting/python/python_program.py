"""Build the walls around a whole Python program, such as a student's, then run it within them.

It may compute, have threads, use the sockets that it was given, and write into its folder. It cannot open sockets,
start processes, send signals, or open other files than Python's library and the installed packages. Without Landlock
and seccomp it does not run.

Arguments: the number of the lifeline; the socket to its server; megabytes of memory, megabytes of a file, seconds of
processor time; the folder; the program; folders that it may read.
"""

from __future__ import annotations

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # isolated Python leaves it out

import python_confine
import python_launcher
import python_limits


def main() -> None:
    """Confine this process, and execute the program by ``simx-run``."""
    lifeline, door, memory, file_size, seconds, folder, program, *readable = sys.argv[1:]
    python_launcher.end_with(int(lifeline))
    os.set_inheritable(int(door), True)
    os.chdir(folder)
    if missing := python_confine.missing():
        _refuse(f"this kernel or container has no {' and no '.join(missing)}")
    shared = python_confine.mapped_files()
    may_write = python_confine.landlock_version() >= python_confine.WRITING_SINCE
    readable += [folder, f"{sys.base_prefix}/lib", os.devnull, *python_launcher.virtual_environment()]
    python_confine.limit_program(int(memory) << 20, int(file_size) << 20, int(seconds))
    command = [sys.executable, "-s", "-B", "-u", "-m", "simx_client.launch.run", program]
    try:
        python_confine.run(
            os.path.realpath("/proc/self/exe"),
            command,
            readable,
            shared,
            int(lifeline),
            of_program=True,
            writable=[folder, os.devnull] if may_write else (),
        )
    except OSError as problem:
        _refuse(str(problem))


def _refuse(why: str) -> None:
    print(f"the program is not run, since nothing would confine it: {why}", file=sys.stderr, flush=True)
    os._exit(python_limits.NOT_CONFINED)


if __name__ == "__main__":
    main()
