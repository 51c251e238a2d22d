"""The choice of a rendering back end, and a server process that lives whatever MUJOCO_GL says."""

import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from simx_server.scene.cameras.image import RenderError
from simx_server.sensors.opengl import backend as gl_backend
from simx_server.sensors.opengl import libraries as gl_libraries
from simx_server.sensors.opengl.backend import Backend, choose_backend, probe_in_child, requested_backend
from simx_server.sensors.opengl.probe import what_is_wrong
from simx_server.sensors.opengl.renderer import OpenGLRenderer

pytestmark = [pytest.mark.slow, pytest.mark.gl]

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(autouse=True)
def no_choice_from_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)


class Probes:
    """Stands in for the child process: the named back ends work."""

    def __init__(self, *working: str) -> None:
        self.working = working
        self.tried: list[str] = []

    def __call__(self, name: str, give_up: threading.Event) -> str | None:
        self.tried.append(name)
        return None if name in self.working else "no such library"


def python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    without = {name: value for name, value in os.environ.items() if name not in ("MUJOCO_GL", "DISPLAY")}
    return subprocess.run(
        [sys.executable, "-c", code],
        env=without | {"PYTHONPATH": str(ROOT)} | environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_the_first_back_end_that_works_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gl_backend, "candidates", lambda: ("egl", "osmesa", "glfw"))
    probes = Probes("osmesa", "glfw")
    assert choose_backend(probe=probes) == Backend("osmesa", "osmesa rendered a test image")
    assert probes.tried == ["egl", "osmesa"]


def test_without_opengl_rays_are_cast_and_the_reason_says_what_to_install() -> None:
    backend = choose_backend(probe=Probes())
    assert backend.name == "raycast"
    assert "no such library" in backend.reason
    assert "install" in backend.reason


@pytest.mark.parametrize(
    ("asked", "taken"),
    [("egl", "egl"), ("OSMesa ", "osmesa"), ("glx", "glfw"), ("disable", "raycast"), ("off", "raycast")],
)
def test_mujoco_gl_is_obeyed_unproven(monkeypatch: pytest.MonkeyPatch, asked: str, taken: str) -> None:
    monkeypatch.setenv("MUJOCO_GL", asked)
    probes = Probes()
    assert choose_backend(probe=probes).name == taken
    assert probes.tried == []


def test_an_argument_outranks_mujoco_gl(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "egl")
    assert choose_backend("raycast").name == "raycast"


@pytest.mark.parametrize("asked", ["", "on", "true"])
def test_mujoco_gl_switched_on_leaves_the_choice_free(monkeypatch: pytest.MonkeyPatch, asked: str) -> None:
    monkeypatch.setenv("MUJOCO_GL", asked)
    assert requested_backend() is None


def test_an_unknown_mujoco_gl_names_the_valid_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "vulkan")
    with pytest.raises(ValueError, match=r"'vulkan'.*egl.*glfw.*osmesa.*unset"):
        choose_backend(probe=Probes("egl"))


def test_giving_up_ends_the_choice() -> None:
    give_up = threading.Event()
    give_up.set()
    with pytest.raises(RenderError, match="closing"):
        choose_backend(give_up=give_up)


def test_a_back_end_that_works_is_tried_once_for_all_simulations_of_a_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    probes = Probes("osmesa")
    monkeypatch.setattr(gl_backend, "probe_in_child", probes)
    monkeypatch.setattr(gl_backend, "candidates", lambda: ("egl", "osmesa"))
    monkeypatch.setenv("SIMX_TEST", "first")
    assert [choose_backend().name for _ in range(2)] == ["osmesa", "osmesa"]
    assert probes.tried == ["egl", "osmesa", "egl"]
    monkeypatch.setenv("SIMX_TEST", "second")
    assert choose_backend().name == "osmesa"
    assert probes.tried[3:] == ["egl", "osmesa"]


def test_a_probe_reports_what_is_wrong_in_one_line() -> None:
    wrong = probe_in_child("no such back end", threading.Event())
    assert wrong is not None
    assert "\n" not in wrong


def test_a_probe_that_takes_too_long_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gl_backend, "PROBE_LIMIT", 0.0)
    assert "no answer" in (probe_in_child("egl", threading.Event()) or "")


def test_a_probe_that_waits_for_a_processor_has_more_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gl_backend, "PROBE_LIMIT", 0.0)
    monkeypatch.setattr(gl_backend, "delay", lambda _process: 1000.0)
    assert "no answer" not in (probe_in_child("no such back end", threading.Event()) or "no answer")


def without_libraries(monkeypatch: pytest.MonkeyPatch, *absent: str) -> None:
    """The system's loader finds none whose name starts so."""

    def load(name: str, *_: Any, **__: Any) -> None:
        if name.startswith(absent):
            raise OSError(f"{name}: cannot open shared object file: No such file or directory")

    monkeypatch.setattr(gl_libraries.ctypes, "CDLL", load)


@pytest.mark.skipif(sys.platform != "linux", reason="names Linux's libraries")
def test_the_warning_without_opengl_names_the_libraries_and_an_install_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    without_libraries(monkeypatch, "libEGL", "libOpenGL", "libGL", "libOSMesa")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    backend = choose_backend(probe=lambda name, give_up: what_is_wrong(name))
    assert backend.name == "raycast"
    assert "egl: libEGL.so.1 and libOpenGL.so.0 are missing (packages libegl1 libopengl0)" in backend.reason
    assert "osmesa: libOSMesa.so.8 is missing (package libosmesa6)" in backend.reason
    assert "glfw: there is no display" in backend.reason
    assert "apt-get install libegl1 libopengl0 libgl1-mesa-dri" in backend.reason
    assert "NoneType" not in backend.reason


@pytest.mark.skipif(sys.platform != "linux", reason="names Linux's libraries")
def test_one_library_that_is_missing_is_named_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    without_libraries(monkeypatch, "libEGL")
    assert gl_libraries.missing_libraries("egl") == "libEGL.so.1 is missing (package libegl1)"
    without_libraries(monkeypatch, "libOpenGL")  # PyOpenGL takes libGL.so.1 then
    assert gl_libraries.missing_libraries("egl") is None
    monkeypatch.setenv("DISPLAY", ":9")
    assert gl_libraries.missing_libraries("glfw") is None


@pytest.mark.skipif(sys.platform != "linux", reason="hides the drivers in the way of Linux's libglvnd")
def test_libraries_without_a_driver_are_told_apart_from_none() -> None:
    if gl_libraries.missing_libraries("egl"):
        pytest.skip("libEGL is not installed here")
    done = python(
        "import sys; from simx_server.sensors.opengl.probe import main; sys.exit(main(['egl']))",
        __EGL_VENDOR_LIBRARY_FILENAMES="/nonexistent.json",
        __EGL_VENDOR_LIBRARY_DIRS="/nonexistent",
    )
    assert done.returncode == 1
    assert "no OpenGL driver works (package libgl1-mesa-dri" in done.stderr.splitlines()[-1]


@pytest.mark.skipif(sys.platform != "linux", reason="names Linux's libraries")
def test_a_back_end_that_was_asked_for_names_its_libraries_too(monkeypatch: pytest.MonkeyPatch) -> None:
    import mujoco

    def broken(width: int, height: int) -> None:
        raise AttributeError("'NoneType' object has no attribute 'eglQueryString'")

    monkeypatch.setitem(gl_backend._CONTEXT_MODULES, "egl", "mujoco.glfw")
    monkeypatch.setattr("mujoco.glfw.GLContext", broken)
    without_libraries(monkeypatch, "libEGL")
    with pytest.raises(RenderError, match=r"with egl \(libEGL.so.1 is missing .*apt-get install") as failed:
        OpenGLRenderer(mujoco.MjModel.from_xml_string("<mujoco/>"), "egl")
    assert "NoneType" not in str(failed.value)


def test_a_context_that_cannot_be_made_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    import mujoco

    def broken(width: int, height: int) -> None:
        raise RuntimeError("no driver")

    monkeypatch.setattr("mujoco.glfw.GLContext", broken)
    monkeypatch.setattr(gl_libraries, "missing_libraries", lambda name: None)
    with pytest.raises(RenderError, match=r"glfw .*no driver.*unset MUJOCO_GL.*disable"):
        OpenGLRenderer(mujoco.MjModel.from_xml_string("<mujoco/>"), "glfw")


@pytest.mark.skipif(sys.platform != "linux", reason="hides the drivers in the way of Linux's libglvnd")
def test_a_machine_without_drivers_casts_rays() -> None:
    """EGL finds no vendor, PyOpenGL refuses OSMesa, GLFW finds no display: whatever is installed, nothing works."""
    done = python(
        "from simx_server.sensors.opengl.backend import choose_backend; print(choose_backend().name)",
        PYOPENGL_PLATFORM="egl",
        __EGL_VENDOR_LIBRARY_FILENAMES="/nonexistent.json",
        __EGL_VENDOR_LIBRARY_DIRS="/nonexistent",
        WAYLAND_DISPLAY="",
        XDG_RUNTIME_DIR="/nonexistent",
    )
    assert done.stdout.strip() == "raycast", done.stderr


@pytest.mark.parametrize("value", ["nonsense", "osmesa", "egl", "disable"])
def test_mujoco_imports_whatever_mujoco_gl_says(value: str) -> None:
    done = python(
        "import os, sys\n"
        "before = dict(os.environ)\n"
        "from simx_server.sensors.opengl.mujoco_import import import_mujoco\n"
        "import_mujoco()\n"
        "import mujoco\n"
        "mujoco.MjModel.from_xml_string('<mujoco/>')\n"
        "print(os.environ['MUJOCO_GL'])",
        MUJOCO_GL=value,
        # Makes `osmesa` fail to import even where its library is installed.
        PYOPENGL_PLATFORM="egl",
    )
    assert done.stdout.strip() == value, done.stderr
