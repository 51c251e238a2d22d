"""The elements of a spec, in its order, in a time that grows with their number.

`MjSpec.geoms`, `.sites` and so on search the whole tree for each next element: 5,000 geoms of as many bodies take 0.2 s
there, and 3 ms here.
"""

from __future__ import annotations

from typing import Any

import mujoco


def bodies_of(spec: mujoco.MjSpec) -> list[Any]:
    """Return the world and all bodies, as `spec.bodies`: each body before those below it."""
    found: list[Any] = []
    waiting: list[Any] = [spec.worldbody]
    while waiting:
        body = waiting.pop()
        found.append(body)
        waiting.extend(reversed(body.bodies))
    return found


def leaves_of(spec: mujoco.MjSpec, many: str) -> list[Any]:
    """Return all elements of a kind that bodies have, as the list of the spec with this name does.

    Args:
        many: "geoms", "sites", "joints", "cameras", "lights" or "frames".
    """
    return [leaf for body in bodies_of(spec) for leaf in getattr(body, many)]
