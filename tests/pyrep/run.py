"""Run PyRep's own tests over this project: ``python tests/pyrep/run.py PATH [TEST ...]``.

PATH is a checkout of PyRep, which is not changed; each TEST is a name for unittest, such as ``tests.test_joints``.
Tests whose scene is not in the checkout are named and not run.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

import argparse
import ast
import os
import re
import sys
import unittest
from collections.abc import Iterator
from pathlib import Path

import simx_client.pyrep

SUCCESS, FAILURE = 0, 1


def scenes_of(module: Path) -> list[str]:
    """Return the scene files that a module of tests names."""
    texts = (
        node.value
        for node in ast.walk(ast.parse(module.read_text("utf-8")))
        if isinstance(node, ast.Constant)
    )
    return [text for text in texts if isinstance(text, str) and re.fullmatch(r"test_scene\w*\.ttt", text)]


def modules(checkout: Path) -> Iterator[tuple[str, str]]:
    """Yield the name of each module of tests, with the scene that it lacks, or an empty text."""
    for path in sorted((checkout / "tests").glob("test_*.py")):
        missing = [name for name in scenes_of(path) if not (checkout / "tests" / "assets" / name).exists()]
        yield f"tests.{path.stem}", missing[0] if missing else ""


def main() -> int:
    """Run the tests; return 1 if one failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("checkout", metavar="PATH", type=Path)
    parser.add_argument("tests", metavar="TEST", nargs="*")
    options = parser.parse_args()
    simx_client.pyrep.activate()
    checkout = options.checkout.resolve()
    # The checkout has a package named tests, as this project has a folder.
    sys.path[:] = [
        str(checkout),
        *(each for each in sys.path if Path(each or ".").resolve() != Path(__file__).parent),
    ]
    os.chdir(checkout)
    names: list[str] = options.tests
    if not names:
        for name, missing in modules(checkout):
            if missing:
                print(f"{name}: not run, the checkout has no {missing}")
            else:
                names.append(name)
    suite = unittest.defaultTestLoader.loadTestsFromNames(names)
    outcome = unittest.TextTestRunner(verbosity=1, warnings="ignore").run(suite)
    passed = outcome.testsRun - len(outcome.failures) - len(outcome.errors)
    print(f"{passed} of {outcome.testsRun} tests pass")
    return SUCCESS if outcome.wasSuccessful() else FAILURE


if __name__ == "__main__":
    sys.exit(main())
