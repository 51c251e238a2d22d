"""Checkouts of PyRep and RLBench, whose models some tests read; those are skipped without them.

They lie in the folder of V-REP's sample files, or where the variables `PYREP_CHECKOUT` and `RLBENCH_CHECKOUT` say.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

_SHARED = Path(__file__).resolve().parents[4] / "shared"


def _checkout(name: str) -> Path:
    return Path(os.environ.get(f"{name.upper()}_CHECKOUT") or _SHARED / name)


PYREP_GRIPPERS = _checkout("PyRep") / "robot_ttms" / "end_effectors"
RLBENCH = _checkout("RLBench") / "rlbench"

needs_pyrep = pytest.mark.skipif(not PYREP_GRIPPERS.is_dir(), reason="PyRep's models are not here")


def model_of_rlbench(name: str) -> Path:
    """Return a model in RLBench's package; skips the test without it."""
    path = RLBENCH / name
    if not path.exists():
        pytest.skip("RLBench's models are not here")
    return path
