"""Check which OpenGL back ends render on this machine, and render a test image of the scene."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from simx_server.sensors.opengl.backend import RAYCAST, candidates, probe_in_child, requested_backend
from simx_server.sensors.opengl.libraries import INSTALL_HINT, install_advice

from .child import ProbeFailed, run_probe
from .findings import OK, PROBLEM, WARNING, Finding

IMAGE_TIMEOUT = 120.0
"""Time-out in seconds, for a large scene on a busy machine."""


def check_backends(probe: Callable[[str, threading.Event], str | None] = probe_in_child) -> Iterator[Finding]:
    """Check each back end in a separate process, all at the same time."""
    try:
        asked = requested_backend()
    except ValueError as error:
        yield Finding(PROBLEM, "graphics", str(error), "unset MUJOCO_GL")
        return
    names = candidates()
    give_up = threading.Event()

    def ask(name: str) -> str | None:
        return probe(name, give_up)

    with ThreadPoolExecutor(len(names), thread_name_prefix="simx-doctor") as pool:
        wrongs = dict(zip(names, pool.map(ask, names), strict=True))
    working = [name for name, wrong in wrongs.items() if wrong is None]
    for name, wrong in wrongs.items():
        if wrong is None:
            yield Finding(OK, "graphics", f"{name} rendered a test image")
        elif name == asked:
            text = f"MUJOCO_GL asks for {name}, which cannot render: {wrong}"
            yield Finding(PROBLEM, "graphics", text, f"unset MUJOCO_GL; or {install_advice(name)}")
        else:
            advice = "" if working else install_advice(name)
            yield Finding(OK if working else WARNING, "graphics", f"{name} cannot render: {wrong}", advice)
    if asked == RAYCAST:
        yield Finding(OK, "graphics", "MUJOCO_GL asks for images by casting rays, which needs no OpenGL")
    elif not working and asked is None:
        yield Finding(WARNING, "graphics", "images are made by casting rays, which is slower", INSTALL_HINT)


def check_scene(scene: str | None) -> list[Finding]:
    """Load the scene that a server would load, and render its first vision sensor, in a separate process."""
    arguments = () if scene is None else (scene,)
    try:
        found = run_probe("simx_server.app.doctor.image_probe", *arguments, timeout=IMAGE_TIMEOUT)
    except ProbeFailed as error:
        advice = "see what is said of graphics above; MUJOCO_GL=disable casts rays in place of OpenGL"
        return [Finding(PROBLEM, "image", f"no test image: {error}", advice)]
    solver = [Finding(WARNING, "solver", found["solver"])] if found["solver"] else []
    return [*solver, _judge_image(found)]


def _judge_image(found: dict[str, Any]) -> Finding:
    if found["sensor"] is None:
        return Finding(OK, "image", f"the scene {found['scene']} has no vision sensor to make one with")
    text = (
        f"{found['sensor']} of {found['scene']}, {found['width']}x{found['height']} with {found['backend']}: "
        f"{found['colours']} colours, brightness {found['darkest']} to {found['brightest']}, "
        f"surfaces on {found['covered']:.0%} of it; {found['milliseconds']:.0f} ms an image"
    )
    if found["colours"] < 2:
        advice = "try another back end: MUJOCO_GL=osmesa, or MUJOCO_GL=disable for rays"
        return Finding(WARNING, "image", f"{text}; it is blank", advice)
    return Finding(OK, "image", text)
