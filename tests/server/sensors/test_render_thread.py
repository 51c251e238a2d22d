"""The render thread: nothing is rendered twice, no client waits, nothing takes it down."""

import dataclasses
import logging
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest
from camera_world import FRONT, SCENE, load, pixel_of
from processes import wait_until

from simx_server.limits import Limits
from simx_server.scene.cameras.image import PART, CameraImage, CameraView, Renderer, RenderError, nothing
from simx_server.sensors.opengl.backend import Backend
from simx_server.sensors.rendering import jobs, render_thread
from simx_server.sensors.rendering.image_queue import ImageQueue
from simx_server.sensors.rendering.newest import NewestImages
from simx_server.sensors.rendering.render_thread import RenderThread

pytestmark = [pytest.mark.slow, pytest.mark.gl]

WAIT = 30.0
TWIN = '<camera name="twin" pos="0 -2 0" xyaxes="1 0 0 0 0 1"/>'


class ScriptedRenderer:
    """Renders nothing but notes what it was asked; waits for `go` and fails when told to."""

    def __init__(self) -> None:
        self.go = threading.Event()
        self.go.set()
        self.started = threading.Event()
        self.rested = threading.Event()
        self.seen: list[tuple[float, int, bool, bool]] = []
        self.made = 0
        self.turned = 0
        self.together = 0
        self.closed = 0
        self.fail_next = False
        self.missing: int | None = None
        self.threads: set[int] = set()

    def make(self, model: mujoco.MjModel, backend: Backend) -> Renderer:
        self.made += 1
        self.threads.add(threading.get_ident())
        return self

    def turn_to(self, model: mujoco.MjModel) -> None:
        self.threads.add(threading.get_ident())
        self.turned += 1

    def render(
        self,
        data: mujoco.MjData,
        view: CameraView,
        rgb: bool,
        depth: bool,
        let_in: Callable[[], None] = nothing,
    ) -> CameraImage:
        self.threads.add(threading.get_ident())
        self.started.set()
        assert self.go.wait(WAIT)
        if view.camera_id == self.missing:
            raise RenderError("there is no such camera")
        if self.fail_next:
            self.fail_next = False
            raise RuntimeError("the driver lost its mind")
        for _ in range(view.width * view.height // PART):
            let_in()
        self.seen.append((data.time, view.camera_id, rgb, depth))
        size = (view.height, view.width)
        return CameraImage(
            np.zeros((*size, 3), np.uint8) if rgb else None, np.ones(size, np.float32) if depth else None
        )

    def render_both(
        self,
        data: mujoco.MjData,
        view: CameraView,
        coded: CameraView,
        let_in: Callable[[], None] = nothing,
    ) -> tuple[CameraImage, CameraImage]:
        self.together += 1
        return self.render(data, view, True, True, let_in), self.render(data, coded, True, True, let_in)

    def rest(self) -> None:
        self.threads.add(threading.get_ident())
        self.rested.set()

    def close(self) -> None:
        self.threads.add(threading.get_ident())
        self.closed += 1


@pytest.fixture
def scripted() -> ScriptedRenderer:
    return ScriptedRenderer()


@pytest.fixture
def thread(scripted: ScriptedRenderer) -> Iterator[RenderThread]:
    thread = RenderThread(choose=lambda: Backend("raycast", "a test asked for it"), make=scripted.make)
    yield thread
    scripted.go.set()
    thread.close()


class Asker:
    """Asks a render thread for pictures of one world at chosen times."""

    def __init__(self, thread: RenderThread, xml: str = SCENE) -> None:
        self.thread = thread
        self.model, self.data = load(xml)

    def ask(
        self, time: float, view: CameraView = FRONT, rgb: bool = True, depth: bool = False
    ) -> "Future[CameraImage]":
        self.data.time = time
        return self.thread.request(self.model, self.data, view, rgb=rgb, depth=depth, version=time)


def test_equal_requests_of_one_version_render_once(scripted: ScriptedRenderer, thread: RenderThread) -> None:
    asker = Asker(thread)
    scripted.go.clear()
    first = asker.ask(1.0)
    assert scripted.started.wait(WAIT)
    while_running = asker.ask(1.0)
    scripted.go.set()
    picture = first.result(WAIT)
    afterwards = asker.ask(1.0)
    assert while_running.result(WAIT) is picture
    assert afterwards.result(WAIT) is picture
    assert len(scripted.seen) == 1


def test_a_waiting_image_takes_on_the_other_channel(scripted: ScriptedRenderer, thread: RenderThread) -> None:
    asker = Asker(thread)
    scripted.go.clear()
    asker.ask(1.0)
    assert scripted.started.wait(WAIT)
    colour = asker.ask(2.0)
    depth = asker.ask(2.0, rgb=False, depth=True)
    scripted.go.set()
    assert colour.result(WAIT) is depth.result(WAIT)
    assert scripted.seen[1:] == [(2.0, 0, True, True)]


def test_the_other_channel_of_a_made_image_makes_both(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker = Asker(thread)
    asker.ask(1.0).result(WAIT)
    both = asker.ask(1.0, rgb=False, depth=True).result(WAIT)
    assert both.rgb is not None
    assert asker.ask(1.0).result(WAIT) is both
    assert len(scripted.seen) == 2


def test_each_version_gets_its_own_instant(scripted: ScriptedRenderer, thread: RenderThread) -> None:
    asker = Asker(thread)
    scripted.go.clear()
    pictures = [asker.ask(time) for time in (1.0, 2.0, 3.0)]
    scripted.go.set()
    assert len({id(picture.result(WAIT)) for picture in pictures}) == 3
    assert [time for time, *_ in scripted.seen] == [1.0, 2.0, 3.0]


def test_different_views_of_one_version_render_each(scripted: ScriptedRenderer, thread: RenderThread) -> None:
    asker = Asker(thread)
    views = (FRONT, dataclasses.replace(FRONT, camera_id=1), dataclasses.replace(FRONT, far=2.0))
    for future in [asker.ask(1.0, view) for view in views]:
        future.result(WAIT)
    assert len(scripted.seen) == 3


def test_two_cameras_in_one_place_share_an_image(scripted: ScriptedRenderer, thread: RenderThread) -> None:
    asker = Asker(thread, WITH_TWIN)
    twins = FRONT, dataclasses.replace(FRONT, camera_id=1)
    colours, depths = (asker.ask(1.0, view, depth=True) for view in twins)
    assert colours.result(WAIT) is depths.result(WAIT)
    assert asker.ask(1.0, twins[1]).result(WAIT) is colours.result(WAIT)
    shorter = asker.ask(1.0, dataclasses.replace(twins[1], far=2.0)).result(WAIT)
    assert shorter is not colours.result(WAIT)
    # Neither takes the other's newest picture away.
    assert asker.ask(1.0, twins[0]).result(WAIT) is colours.result(WAIT)
    assert len(scripted.seen) == 2


CODED = dataclasses.replace(FRONT, camera_id=1, codes=(1, 2, 3, 4, 5), background=(1.0, 1.0, 1.0))
WITH_TWIN = SCENE.replace("<camera", TWIN + "<camera", 1)


def test_colours_and_codes_that_are_requested_together_are_rendered_together(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker = Asker(thread, WITH_TWIN)
    for time in (1.0, 2.0, 3.0):
        colours = asker.ask(time, FRONT, depth=True).result(WAIT)
        codes = asker.ask(time, CODED, depth=True).result(WAIT)
        assert codes is not colours
        assert asker.ask(time, CODED).result(WAIT) is codes
    assert scripted.together == 2
    assert len(scripted.seen) == 6


def test_an_error_while_two_images_are_rendered_together_fails_both(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker = Asker(thread, WITH_TWIN)
    for view in (FRONT, CODED):
        asker.ask(1.0, view).result(WAIT)
    scripted.go.clear()
    scripted.fail_next = True
    both = [asker.ask(2.0, view) for view in (FRONT, CODED)]
    scripted.go.set()
    for future in both:
        with pytest.raises(RenderError, match="lost its mind"):
            future.result(WAIT)
    assert asker.ask(2.0, CODED).result(WAIT).rgb is not None, "a later request tries again"


def test_small_images_are_made_between_the_parts_of_a_large_one(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker = Asker(thread)
    scripted.go.clear()
    large = asker.ask(1.0, dataclasses.replace(FRONT, width=2048, height=2048))
    assert scripted.started.wait(WAIT)
    another_large = asker.ask(2.0, dataclasses.replace(FRONT, width=2048, height=2048))
    small = asker.ask(3.0)
    scripted.go.set()
    for picture in (large, another_large, small):
        picture.result(WAIT)
    assert [time for time, *_ in scripted.seen] == [3.0, 1.0, 2.0]


def test_a_small_image_that_cannot_be_made_does_not_harm_the_large_one(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker = Asker(thread)
    scripted.go.clear()
    large = asker.ask(1.0, dataclasses.replace(FRONT, width=2048, height=2048))
    assert scripted.started.wait(WAIT)
    small = asker.ask(3.0, dataclasses.replace(FRONT, camera_id=99))
    scripted.missing = 99
    scripted.go.set()
    with pytest.raises(RenderError, match="camera id 99"):
        small.result(WAIT)
    assert large.result(WAIT).rgb is not None
    assert scripted.closed == 0


def test_who_asks_for_little_is_served_before_who_asks_for_much() -> None:
    queue: ImageQueue[str] = ImageQueue(most=4)
    for job in ("a1", "a2", "a3"):
        assert queue.put(job, "a") is None
    assert queue.take() == "a1"
    queue.took("a", 3.0)
    assert queue.put("b1", "b") is None
    assert queue.take() == "b1"
    queue.took("b", 0.1)
    queue.put("b2", "b")
    assert queue.take() == "b2"  # who comes again has not had its share yet
    queue.took("b", 5.0)
    queue.put("b3", "b")
    assert [queue.take(), queue.take(), queue.take(), queue.take()] == ["a2", "a3", "b3", None]


def test_who_has_most_waiting_images_loses_one_when_there_are_too_many() -> None:
    queue: ImageQueue[str] = ImageQueue(most=3)
    assert [queue.put(job, "a") for job in ("a1", "a2", "a3")] == [None, None, None]
    assert queue.put("b1", "b") == "a3"
    assert queue.put("a4", "a") == "a4"
    assert queue.put("b2", "b") == "b2"  # as many as the other: it is the newcomer that goes
    assert len(queue) == 3
    assert sorted(queue.clear()) == ["a1", "a2", "b1"]
    assert queue.take() is None


def test_large_images_are_not_all_kept() -> None:
    class Made(NamedTuple):
        key: int
        cameras: frozenset[int]

    kept: NewestImages[Any] = NewestImages(room=100)
    shared, second, third = Made(1, frozenset({1, 2})), Made(2, frozenset({3})), Made(3, frozenset({1}))
    kept.keep(shared, 60)
    kept.keep(second, 40)
    assert kept.of(1) is kept.of(2) is shared
    kept.keep(third, 40)  # more than there is room for: the oldest goes
    assert (kept.of(2), kept.of(3), kept.of(1)) == (None, second, third)
    assert kept.find(1) is None
    kept.keep(Made(4, frozenset({4})), 1000)  # the newest is kept whatever it needs
    assert (kept.of(1), kept.of(3)) == (None, None)
    assert kept.of(4) is not None


def test_memory_is_given_back_when_nobody_asks_any_more(
    scripted: ScriptedRenderer, thread: RenderThread, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(render_thread, "RESTS_AFTER", 0.0)
    asker = Asker(thread)
    first = asker.ask(1.0).result(WAIT)
    assert scripted.rested.wait(WAIT)
    assert asker.ask(1.0).result(WAIT) is not first


def test_who_asks_for_both_channels_one_by_one_gets_them_from_one_pass_next_time(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker = Asker(thread)

    def ask_both(time: float) -> None:
        asker.ask(time).result(WAIT)
        asker.ask(time, rgb=False, depth=True).result(WAIT)

    for time in (1.0, 2.0, 3.0):
        ask_both(time)
    assert scripted.seen == [(1.0, 0, True, False), *((time, 0, True, True) for time in (1.0, 2.0, 3.0))]
    for time in (4.0, 5.0):
        asker.ask(time).result(WAIT)
    assert scripted.seen[-2:] == [(4.0, 0, True, True), (5.0, 0, True, False)]


def test_a_failed_image_leaves_the_thread_usable(scripted: ScriptedRenderer, thread: RenderThread) -> None:
    asker = Asker(thread)
    scripted.fail_next = True
    with pytest.raises(RenderError, match=r"camera id 0 could not be rendered with raycast: the driver lost"):
        asker.ask(1.0).result(WAIT)
    asker.ask(1.0).result(WAIT)
    assert (scripted.made, scripted.closed) == (2, 1)


def test_a_back_end_that_cannot_be_chosen_fails_the_image() -> None:
    def choose() -> Backend:
        raise ValueError("MUJOCO_GL='nonsense' is not a way to render")

    thread = RenderThread(choose=choose)
    try:
        with pytest.raises(RenderError, match="nonsense"):
            Asker(thread).ask(1.0).result(WAIT)
    finally:
        thread.close()


def test_the_renderer_turns_to_another_model(scripted: ScriptedRenderer, thread: RenderThread) -> None:
    one, other = Asker(thread), Asker(thread)
    first = one.ask(1.0).result(WAIT)
    second = other.ask(1.0).result(WAIT)
    assert first is not second
    assert (scripted.made, scripted.turned, scripted.closed) == (1, 1, 0)


def test_closing_fails_what_waits_and_finishes_what_runs(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker = Asker(thread)
    scripted.go.clear()
    running = asker.ask(1.0)
    assert scripted.started.wait(WAIT)
    waiting = asker.ask(2.0)
    waiting.add_done_callback(lambda _: scripted.go.set())
    thread.close()
    assert running.result(WAIT).rgb is not None
    with pytest.raises(RenderError, match="closing"):
        waiting.result(WAIT)
    with pytest.raises(RenderError, match="closed"):
        asker.ask(3.0).result(WAIT)
    assert scripted.closed == 1
    assert not [each for each in threading.enumerate() if each.name == "simx-render"]
    thread.close()


def test_the_renderer_lives_on_one_thread_that_is_not_the_askers(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker = Asker(thread)
    asker.ask(1.0).result(WAIT)
    asker.ask(2.0).result(WAIT)
    thread.close()
    assert len(scripted.threads) == 1
    assert threading.get_ident() not in scripted.threads


def test_a_flood_of_requests_is_refused_not_stored(scripted: ScriptedRenderer, thread: RenderThread) -> None:
    asker = Asker(thread)
    scripted.go.clear()
    asker.ask(0.0)
    assert scripted.started.wait(WAIT)
    accepted = [asker.ask(float(time)) for time in range(1, Limits().pictures + 1)]
    with pytest.raises(RenderError, match="ask less often"):
        asker.ask(1e6).result(WAIT)
    scripted.go.set()
    for future in accepted:
        future.result(WAIT)


def test_a_cancelled_image_is_not_made_and_not_shared(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker = Asker(thread)
    scripted.go.clear()
    asker.ask(1.0)
    assert scripted.started.wait(WAIT)
    cancelled = asker.ask(2.0)
    assert cancelled.cancel()
    again = asker.ask(2.0)
    scripted.go.set()
    again.result(WAIT)
    assert [time for time, *_ in scripted.seen] == [1.0, 2.0]


def prepare(thread: RenderThread, asker: Asker) -> "Future[None]":
    return thread.prepare(asker.model, asker.data, [FRONT], version="prepared")


def test_preparing_makes_the_renderer_and_draws_each_view_once(scripted: ScriptedRenderer) -> None:
    thread = RenderThread(choose=lambda: Backend("egl", "a test asked for it"), make=scripted.make)
    try:
        asker = Asker(thread)
        prepare(thread, asker).result(WAIT)
        assert thread.backend == Backend("egl", "a test asked for it")
        assert scripted.seen == [(0.0, 0, True, True)]
        assert not thread.times.by_camera  # nobody has asked for it
        asker.ask(1.0).result(WAIT)
        assert scripted.made == 1
    finally:
        thread.close()


def test_rays_are_not_cast_before_somebody_asks(scripted: ScriptedRenderer, thread: RenderThread) -> None:
    prepare(thread, Asker(thread)).result(WAIT)
    assert (scripted.made, scripted.seen) == (1, [])


def test_a_later_preparation_takes_the_place_of_one_that_waits(
    scripted: ScriptedRenderer, thread: RenderThread
) -> None:
    asker, scene = Asker(thread), Asker(thread)
    scripted.go.clear()
    running = asker.ask(1.0)
    assert scripted.started.wait(WAIT)
    before = prepare(thread, asker)
    after = prepare(thread, scene)
    before.result(0)
    assert not after.done()
    scripted.go.set()
    running.result(WAIT)
    after.result(WAIT)
    assert (scripted.made, scripted.turned) == (1, 1)


def test_images_fail_while_a_driver_hangs_and_are_made_again_afterwards(
    scripted: ScriptedRenderer,
    thread: RenderThread,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    asker = Asker(thread)
    asker.ask(0.0).result(WAIT)
    thread.watch()
    scripted.started.clear()
    scripted.go.clear()
    monkeypatch.setattr(render_thread, "DRAWN_WITHIN", -1.0)
    running = asker.ask(1.0)
    assert scripted.started.wait(WAIT)
    thread.watch()
    thread.watch()
    for picture in (running, asker.ask(1.0), asker.ask(2.0)):
        with pytest.raises(RenderError, match=r"has been drawing camera id 0 for 0 s.*--doctor"):
            picture.result(WAIT)
    monkeypatch.undo()
    scripted.go.set()
    assert wait_until(lambda: "images can be made again" in caplog.text, WAIT)
    assert asker.ask(1.0).result(WAIT).rgb is not None
    assert [record.levelname for record in caplog.records if "may hang" in record.message] == ["ERROR"]


def test_what_waits_behind_a_hanging_image_fails_with_it(
    scripted: ScriptedRenderer, thread: RenderThread, monkeypatch: pytest.MonkeyPatch
) -> None:
    asker = Asker(thread)
    scripted.go.clear()
    running = asker.ask(1.0)
    assert scripted.started.wait(WAIT)
    waiting = asker.ask(2.0)
    monkeypatch.setattr(jobs.Doing, "is_overdue", lambda self: True)
    thread.watch()
    for picture in (running, waiting):
        with pytest.raises(RenderError, match="graphics driver"):
            picture.result(0)
    assert thread.waiting == 0


def test_closing_gives_up_an_image_that_hangs(
    scripted: ScriptedRenderer, thread: RenderThread, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(render_thread, "_JOIN_TIMEOUT", 0.0)
    scripted.go.clear()
    running = Asker(thread).ask(1.0)
    assert scripted.started.wait(WAIT)
    thread.close()
    with pytest.raises(RenderError, match="closed"):
        running.result(0)
    assert thread.is_stuck
    scripted.go.set()
    monkeypatch.undo()
    thread.close()
    assert not thread.is_stuck


def test_the_back_end_is_logged_once(
    scripted: ScriptedRenderer, thread: RenderThread, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.INFO, logger="simx_server.sensors.rendering.current_renderer"):
        Asker(thread).ask(1.0).result(WAIT)
        Asker(thread).ask(1.0).result(WAIT)
    assert [(record.levelname, record.message) for record in caplog.records] == [
        ("WARNING", "images are made with raycast: a test asked for it")
    ]


def test_a_program_that_forgets_to_close_still_ends() -> None:
    program = """
import mujoco
from simx_server.sensors.opengl.backend import Backend
from simx_server.scene.cameras.image import CameraView
from simx_server.sensors.rendering.render_thread import RenderThread

model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><camera/></worldbody></mujoco>")
data = mujoco.MjData(model)
view = CameraView(camera_id=0, width=4, height=3, fovy_deg=45, near=0.1, far=1)
thread = RenderThread(choose=lambda: Backend("raycast", "for a test"))
thread.request(model, data, view, rgb=True, depth=False, version=0).result(30)
"""
    root = str(Path(__file__).resolve().parents[3])
    environment = os.environ | {"PYTHONPATH": root}
    assert (
        subprocess.run([sys.executable, "-c", program], env=environment, timeout=60, check=False).returncode
        == 0
    )


def test_a_real_image_comes_through_the_thread() -> None:
    thread = RenderThread()
    try:
        asker = Asker(thread)
        before = asker.ask(1.0, depth=True).result(WAIT)
        asker.model, asker.data = load(SCENE.replace('pos="-0.4 0 0.3"', 'pos="0.4 0 0.3"'))
        after = asker.ask(1.0, depth=True).result(WAIT)
        left, right = pixel_of(FRONT, -0.4, 0.3, 2.0), pixel_of(FRONT, 0.4, 0.3, 2.0)
        assert before.depth is not None
        assert after.depth is not None
        assert before.depth[left] < 0.3 < before.depth[right]
        assert after.depth[right] < 0.3 < after.depth[left]
        with pytest.raises(RenderError, match="camera id 9"):
            asker.ask(2.0, dataclasses.replace(FRONT, camera_id=9)).result(WAIT)
        colours = asker.ask(3.0).result(WAIT).rgb
        assert colours is not None
        assert colours[left].any()
    finally:
        thread.close()
