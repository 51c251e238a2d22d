"""Implement ``python -m simx_client shims FOLDER``: write shims for the legacy files, for use without the
launcher.

Each shim is a few lines that work in any folder or package under the old name. They are real modules that
contain every function and constant by name (``from simx_client import *`` with its complete ``__all__``), so
that programs which read ``dir(vrep)`` and type checkers find the same as in the original.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from simx_client.connection.pace import OLD_SCRIPTS, VARIABLE
from simx_client.protocol.cli.exit_codes import DONE, FAILURE

from .command_parser import command_parser

EXAMPLES = """\
example:
  python -m simx_client shims my_project/simulation --force
"""

SURFACE = '''\
"""Stand-in for V-REP's {name}: the same functions and constants, on simx, which has to be installed."""

from os import environ as _environ

_environ.setdefault("{variable}", "{pace}")  # the pace of blocking calls; docs/porting.md

from simx_client import *  # noqa: F403
from simx_client import __getattr__ as __getattr__
'''

CONSTANTS = '''\
"""Stand-in for V-REP's {name}: the same constants, on simx, which has to be installed."""

from simx_client.protocol.constants import *  # noqa: F403
'''

FILES = {"vrep.py": SURFACE, "sim.py": SURFACE, "vrepConst.py": CONSTANTS, "simConst.py": CONSTANTS}


def write_shims(folder: Path, *, force: bool = False) -> list[Path]:
    """Write the shims into `folder`; return those that were written or already existed in this form.

    Nothing is written if a shim would replace another file: FileExistsError names them, unless `force`.
    """
    texts = {
        folder / name: text.format(name=name, variable=VARIABLE, pace=OLD_SCRIPTS)
        for name, text in FILES.items()
    }
    others = [path for path, text in texts.items() if path.exists() and path.read_bytes() != text.encode()]
    if others and not force:
        raise FileExistsError(
            f"{', '.join(map(str, others))} would be replaced; move it away, or use --force to replace it"
        )
    for path, text in texts.items():
        path.write_bytes(text.encode())
    return list(texts)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = command_parser(
        "shims",
        "Write stand-ins for vrep.py, sim.py, vrepConst.py and simConst.py on simx_client.",
        examples=EXAMPLES,
    )
    parser.add_argument(
        "folder", metavar="FOLDER", type=Path, help="folder from which the script imports them"
    )
    parser.add_argument("--force", action="store_true", help="replace files of these names")
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return 0, 1 if nothing was written, 2 if the folder does not exist."""
    parser = make_parser()
    options = parser.parse_args(argv)
    if not options.folder.is_dir():
        parser.error(f"{options.folder} is no folder; name one that exists")
    try:
        written = write_shims(options.folder, force=options.force)
    except OSError as error:
        sys.stderr.write(f"simx_client shims: nothing was written: {error}\n")
        return FAILURE
    sys.stdout.writelines(f"{path}\n" for path in written)
    return DONE
