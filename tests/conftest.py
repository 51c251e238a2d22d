"""The start of every test: an environment without settings of the person who runs it. And figures at the end."""

from __future__ import annotations

import compileall
import gc
import importlib
import logging
import os
import signal
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from kinds_of_tests import add_marker
from processes import PENDULUM, ForkingSubprocess
from real_world import Open, RealWorld, World
from workers import messages
from workers.order import BROWSERS, LEARNING, LONGEST

import simx_client as v
from simx_client.checking import regular as checked_functions
from simx_client.checking import scene as checked_scene
from simx_client.client.worlds import worker
from simx_server.grading.attempt import attempt
from simx_server.scene.formats.vrep.conversion.geometry.colliding import decomposition
from simx_server.scene.trial import helper as trial_helper
from simx_server.sensors.opengl import backend as opengl
from simx_server.world import world as composition

# A shell ignores Ctrl-C for what it starts in the background, and every process that a test starts would inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

TESTS = Path(__file__).parent
YOUNG = 5000
"""New objects after which the garbage collector searches: after 700, Python's, it takes a twentieth of all time."""

FORKING = (checked_functions, checked_scene, worker, attempt)
"""Modules that start servers by `subprocess`."""


def pytest_configure(config: pytest.Config) -> None:
    """Do the common work once, before xdist's workers start."""
    if hasattr(config, "workerinput"):
        plugins = config.pluginmanager.get_plugins()
        messages.gather(next(each for each in plugins if type(each).__name__ == "WorkerInteractor"))
        return
    # Where PYTHONDONTWRITEBYTECODE is set every process that a test starts would compile all this anew.
    for package in ("simx_client", "simx_server", "bench", "tests/support", "tests/fuzz"):
        compileall.compile_dir(TESTS.parent / package, quiet=2)
    if missing := set(LONGEST) - {path.name for path in TESTS.rglob("test_*.py")}:
        raise pytest.UsageError(
            f"LONGEST in tests/support/workers/order.py names files that are not there: {sorted(missing)}"
        )
    is_whole = getattr(config.option, "numprocesses", None) and not config.option.file_or_dir
    if is_whole:
        _write_rewritten_tests()
    if hasattr(config.option, "loadscopereorder"):
        # xdist would begin with the files of most tests; the soak is one test.
        config.option.loadscopereorder = False


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Take the messages of a worker apart."""
    node.process_from_remote = messages.spread(node.process_from_remote)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Give files to xdist's workers, those of `LEARNING` to one, and those of `BROWSERS`."""
    if config.option.dist != "loadfile":
        return None
    from workers.scheduling import FileScheduling

    return FileScheduling(config, log, together=[LEARNING, BROWSERS])


def _write_rewritten_tests() -> None:
    """Have pytest rewrite the asserts of changed tests once, in two processes, so that xdist's workers need not."""
    changed = [path for path in TESTS.rglob("test_*.py") if not _is_rewritten(path)]
    command = [
        sys.executable,
        "-m",
        "pytest",
        "--collect-only",
        "--quiet",
        "-p",
        "no:cacheprovider",
        "-p",
        "no:xdist",
    ]
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": ""}
    begun = [
        subprocess.Popen([*command, *part], env=environment, stdout=subprocess.DEVNULL)
        for part in (changed[::2], changed[1::2])
        if part
    ]
    for process in begun:
        process.wait()
    for path in changed:
        if (rewritten := _rewritten(path)).exists():
            rewritten.touch()  # pytest leaves that of a file whose text is the same, as after a checkout


def _is_rewritten(path: Path) -> bool:
    """Whether pytest has written the module of a test since the test was last changed."""
    rewritten = _rewritten(path)
    return rewritten.exists() and rewritten.stat().st_mtime > path.stat().st_mtime


def _rewritten(path: Path) -> Path:
    tag = f"{sys.implementation.cache_tag}-pytest-{pytest.__version__}"
    return path.parent / "__pycache__" / f"{path.stem}.{tag}.pyc"


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect without the garbage collector, which would search 12,000 tests again and again and find nothing."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(YOUNG)
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Add a marker. Workers of xdist are given the longest files first, then those with most tests."""
    _draw_the_same_random_cases()
    if config.option.markexpr:  # it reads all files
        for item in items:
            add_marker(item)
    if not hasattr(config, "workerinput"):
        return
    counts = Counter(item.path for item in items)
    places = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: (places.get(item.path.name, len(LONGEST)), -counts[item.path], item.path))


def _draw_the_same_random_cases() -> None:
    """Have Hypothesis draw no constants of the project's modules that this process has imported.

    It would parse all of them now, and the cases would depend on the files that are collected.
    """
    if "hypothesis" in sys.modules:
        constants = importlib.import_module("hypothesis.internal.constants_ast").Constants
        pytest.MonkeyPatch().setattr(
            "hypothesis.internal.conjecture.providers._get_local_constants", constants, raising=False
        )


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(nextitem: pytest.Item | None) -> None:
    """End the browser that tests share after the last of them."""
    browsers = sys.modules.get("browsers")
    if browsers is not None and (nextitem is None or nextitem.get_closest_marker("browser") is None):
        browsers.close()


@pytest.fixture(autouse=True, scope="session")
def shared_by_all(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[str]]:
    """Have all that tests share; what `noting_stages` yields. One fixture: each takes time in every test."""
    own = tmp_path_factory.getbasetemp()
    # One folder of what is kept between starts for all workers of this run, so that each part is made once.
    cache = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "cache"
    with (
        no_settings_from_outside(cache),
        shared_trial_helper(),
        shared_probes(),
        forked_servers(),
        noting_stages() as missed,
    ):
        yield missed


@contextmanager
def no_settings_from_outside(cache: Path) -> Iterator[None]:
    """Hide the settings of the person who runs the tests, and use this folder instead of that person's."""
    with pytest.MonkeyPatch.context() as patch:
        for variable in [name for name in os.environ if name.startswith("SIMX_")]:
            patch.delenv(variable)
        patch.setenv("SIMX_CACHE", str(cache))
        yield


@contextmanager
def noting_stages() -> Iterator[list[str]]:
    """Yield the simulation steps in which a part had something to do, or nothing more, and did not call `replan`."""
    missed: list[str] = []
    step = composition.World.step

    def compare_and_step(self: composition.World) -> None:
        if not self.simulation.parts.are_stages_stale and self.stages != (found := self.find_stages()):
            names = [name for name, _ in self.STEP]
            known, present = ([names[number] for number, _ in stages] for stages in (self.stages, found))
            missed.append(f"listed: {known}, to do: {present}")
        step(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(composition.World, "step", compare_and_step)
        yield missed


@pytest.fixture(autouse=True)
def nothing_goes_on(shared_by_all: list[str]) -> Iterator[None]:
    """Restore the logging, as command lines that a test calls set levels and handlers. Fail if a stage was missed."""
    loggers = [logging.getLogger(name) for name in ("", "simx_server", "simx_client", "bench")]
    before = [(logger, logger.level, list(logger.handlers)) for logger in loggers]
    yield
    for logger, level, handlers in before:
        if logger.level != level:  # to set it takes a millisecond
            logger.setLevel(level)
        logger.handlers[:] = handlers
    missed = shared_by_all.copy()
    shared_by_all.clear()
    assert not missed


@pytest.fixture
def coarse_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Decompose the meshes of files as coarsely as those of very large files: the finest parts take seconds."""
    monkeypatch.setattr(decomposition, "MOST_IN_FILE", 0)


@pytest.fixture(scope="module")
def older_objects_set_aside() -> Iterator[None]:
    """Set all objects aside again after tests that measure costs, see `only_own_garbage` in tests/fuzz.

    That brings back those that `pytest_collection` has set aside; each full collection would take half a second more.
    """
    yield
    gc.collect()
    gc.freeze()


@pytest.fixture
def no_connection_left() -> Iterator[None]:
    """Every connection that this process has made is closed after the test."""
    yield
    v.simxFinish(-1)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pendulum's file."""
    path = tmp_path_factory.mktemp("scene") / "pendulum.xml"
    path.write_text(PENDULUM)
    return path


@pytest.fixture
def world() -> Iterator[Open]:
    """Opens scenes, each a whole server in the test's own thread, and closes them."""
    opened: list[RealWorld] = []

    def open_scene(scene: str) -> World:
        opened.append(RealWorld(scene))
        return opened[-1], opened[-1].client()

    yield open_scene
    for each in opened:
        each.close()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Show the ``figures`` that tests recorded, also when they pass."""
    for report in terminalreporter.getreports("passed"):
        for name, value in report.user_properties:
            if name == "figures":
                terminalreporter.write_line(value)


@contextmanager
def shared_trial_helper() -> Iterator[None]:
    """Simulations within this process share the helper that tries clients' files: each would start an interpreter."""
    shared: list[trial_helper.Helper] = []

    def start() -> trial_helper.Helper:
        if not shared or not shared[-1].is_usable:
            shared.append(begin())
        return shared[-1]

    begin, close = trial_helper.start, trial_helper.Helper.close
    trial_helper.start = start
    trial_helper.Helper.close = lambda self: None if self in shared else close(self)
    try:
        yield
    finally:
        trial_helper.start, trial_helper.Helper.close = begin, close
        for each in shared:
            each.close()


@contextmanager
def shared_probes() -> Iterator[None]:
    """Worlds within this process share the test images of OpenGL: each would start a process that draws one."""
    probed: set[tuple[str, tuple[tuple[str, str], ...]]] = set()

    def probe(name: str, give_up: threading.Event) -> str | None:
        variables = sorted(item for item in os.environ.items() if item[0] != "PYTEST_CURRENT_TEST")
        place = (name, tuple(variables))
        wrong = None if place in probed else before(name, give_up)
        if wrong is None:
            probed.add(place)
        return wrong

    before, opengl.probe_in_child = opengl.probe_in_child, probe
    try:
        yield
    finally:
        opengl.probe_in_child = before


@contextmanager
def forked_servers() -> Iterator[None]:
    """Checks of programs, worlds in processes and attempts at exercises fork their servers."""
    with pytest.MonkeyPatch.context() as patch:
        for module in FORKING:
            patch.setattr(module, "subprocess", ForkingSubprocess())
        yield


@pytest.fixture
def started_servers(monkeypatch: pytest.MonkeyPatch) -> None:
    """They start new interpreters, as they do for users."""
    for module in FORKING:
        monkeypatch.setattr(module, "subprocess", subprocess)
