"""The two back ends, as fixtures: a test that makes its renderer with `make_renderer` runs with each."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import mujoco
import pytest

from simx_server.scene.cameras.image import Renderer
from simx_server.sensors.opengl.backend import choose_backend
from simx_server.sensors.opengl.renderer import OpenGLRenderer
from simx_server.sensors.ray_casting.renderer import RaycastRenderer


@pytest.fixture(scope="module")
def opengl_name() -> str:
    """A back end that works here, or the tests that need one are skipped."""
    backend = choose_backend()
    if backend.name == "raycast":
        pytest.skip(backend.reason)
    return backend.name


@pytest.fixture(params=[pytest.param("opengl", marks=pytest.mark.gl), "raycast"])
def make_renderer(request: pytest.FixtureRequest) -> Iterator[Callable[[mujoco.MjModel], Renderer]]:
    """Makes renderers of one kind, and closes them."""
    made: list[Renderer] = []

    def make(model: mujoco.MjModel) -> Renderer:
        if request.param == "raycast":
            made.append(RaycastRenderer(model))
        else:
            made.append(OpenGLRenderer(model, request.getfixturevalue("opengl_name")))
        return made[-1]

    yield make
    for renderer in made:
        renderer.close()
