"""MuJoCo's own renderer with its defaults, in a separate process.

``python -m bench.images.bare FILE CAMERA JOINT=ANGLE ...`` is that process.

For each line with a width and a height it draws one image to a NumPy array and prints a line. The simulation's own
OpenGL cannot be used for that in one process: MuJoCo chooses its back end when it is imported.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager

from bench.measuring.processes import ROOT


class BareRenderer:
    """The near end."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process

    def render(self, size: tuple[int, int]) -> None:
        """Have one image drawn."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{size[0]} {size[1]}\n")
        self._process.stdin.flush()
        if not self._process.stdout.readline():
            raise RuntimeError("the process with MuJoCo's renderer ended by itself")


@contextmanager
def bare_renderer(
    path: str, camera: str, joints: Mapping[str, float] | None = None
) -> Generator[BareRenderer | None]:
    """Yield a renderer of a scene's file; None where OpenGL is missing.

    Args:
        joints: positions in radians by name, of joints that are not at zero.
    """
    backend = os.environ.get("MUJOCO_GL") or "egl"
    command = [sys.executable, "-m", "bench.images.bare", path, camera]
    command += [f"{name}={angle}" for name, angle in (joints or {}).items()]
    with subprocess.Popen(
        command,
        cwd=ROOT,
        env={**os.environ, "MUJOCO_GL": backend},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            yield BareRenderer(process) if process.stdout.readline().strip() == "ready" else None
        finally:
            process.kill()


def main() -> None:
    """Draw until standard input ends."""
    import mujoco

    path, camera, *pose = sys.argv[1:]
    model = mujoco.MjModel.from_xml_path(path)
    model.vis.global_.offwidth, model.vis.global_.offheight = 1280, 960
    data = mujoco.MjData(model)
    for joint, angle in (pair.split("=") for pair in pose):
        data.joint(joint).qpos[0] = float(angle)
    mujoco.mj_forward(model, data)
    renderers: dict[tuple[int, int], mujoco.Renderer] = {}
    renderers[64, 64] = mujoco.Renderer(model, 64, 64)  # fails without OpenGL
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        width, height = map(int, line.split())
        if (width, height) not in renderers:
            renderers[width, height] = mujoco.Renderer(model, height, width, max_geom=model.ngeom + 1000)
        renderers[width, height].update_scene(data, camera)
        renderers[width, height].render()
        sys.stdout.write("drawn\n")
        sys.stdout.flush()


if __name__ == "__main__":
    try:
        main()
    except Exception as error:
        sys.stdout.write(f"no OpenGL: {error}\n")
