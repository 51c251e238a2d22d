"""Numbers of elements, of the kinds that a scene numbers."""

from __future__ import annotations

import mujoco

IN_BODIES = {"joint": "jnt", "site": "site", "camera": "cam", "light": "light"}
"""Kinds of elements that MuJoCo numbers by their bodies, and the prefix of the model's arrays."""

PREFIXES = IN_BODIES | {"body": "body", "tendon": "tendon", "sensor": "sensor"}
"""Kinds of elements that the scene numbers, and the prefix of the model's arrays."""


def sizes_of(model: mujoco.MjModel) -> dict[str, int]:
    """Return the number of elements of a model, by kind."""
    return {kind: int(getattr(model, f"n{prefix}")) for kind, prefix in PREFIXES.items()}
