"""The kept part of a run: steps and calls, within bounds, and only while a viewer wants it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any, cast

import msgpack
import pytest
from past_lab import MACHINE, Lab
from real_world import BLOCKING
from recordings import recorded, replay

import simx_client as v
from simx_client.protocol.add_ons.past import GO_ON, KEEP, STEP
from simx_client.protocol.cli.exit_codes import DONE
from simx_server.history import History, LogOfCalls
from simx_server.limits import Limits
from simx_server.parts.add_ons import ADD_ON_TYPE
from simx_server.recording import state
from simx_server.service.monitoring.log_of_calls import MOST_PER_STEP, Cut, short
from simx_server.viewer.feed import Feed
from simx_server.viewer.messages import ADD_ON, LOOK, PAST, SURVEY

pytestmark = pytest.mark.slow

Open = Callable[[str], Lab]


def ask(client: int, function: str, *ints: int) -> Any:
    """Call the add-on of the web viewer; return what it answers, or the code of a refused call."""
    code, *_, buffer = v.simxCallScriptFunction(
        client, ADD_ON, ADD_ON_TYPE, function, ints, (), (), b"", BLOCKING
    )
    return code if code else msgpack.unpackb(bytes(buffer), strict_map_key=False) if buffer else None


def functions(lab: Lab, step: int) -> list[str]:
    return [called.function for called in lab.history.calls(step).calls]


def test_calls_belong_to_the_step_that_follows_them(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    spin = lab.handle("spin")
    lab.start()
    lab.steps(2)
    v.simxSetJointTargetVelocity(lab.client, spin, 1.5, BLOCKING)
    v.simxGetJointPosition(lab.client, 999, BLOCKING)
    lab.steps(1)
    (set_, get) = lab.history.calls(3).calls
    assert (set_.function, set_.arguments, set_.results, set_.has_failed) == (
        "simxSetJointTargetVelocity", (spin, 1.5), (), False,
    )  # fmt: skip
    assert get.has_failed
    assert get.only_reads
    assert "999" in get.results[0]
    assert functions(lab, 2) == []
    lab.steps(1)
    assert functions(lab, 4) == []


def test_nothing_is_kept_until_somebody_wants_it_and_nothing_after(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    lab.loop.service.watchers.remove(lab.history)
    lab.loop.service.executor.note_in(None)
    history = History(lab.loop.service)
    lab.loop.service.watchers.add(history)
    lab.parts.scripts.add_ons[ADD_ON] = Feed(lab.loop.service, "lab", (), history)
    lab.start()
    lab.steps(3)
    assert history.steps is None
    assert lab.loop.service.executor.log_of_calls is None
    viewer = lab.world.client()
    ask(viewer, KEEP, 1)
    lab.steps(2)
    assert history.steps == (4, 5)
    assert ask(viewer, SURVEY, -1, -1)["past"]["first"] == 4
    ask(viewer, KEEP, 0)
    lab.steps(2)
    assert history.steps == (4, 5)
    ask(viewer, KEEP, 1)
    v.simxFinish(viewer)
    lab.steps(2)
    assert history.steps == (4, 5), "the client that wanted it has left"
    assert lab.loop.service.executor.log_of_calls is None


def test_with_zero_seconds_nothing_is_ever_kept(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    lab.loop.service.watchers.remove(lab.history)
    history = History(lab.loop.service, 0.0)
    lab.loop.service.watchers.add(history)
    lab.parts.scripts.add_ons[ADD_ON] = Feed(lab.loop.service, "lab", (), history)
    ask(lab.client, KEEP, 1)
    lab.start()
    lab.steps(3)
    assert history.steps is None
    assert ask(lab.client, PAST, 1, -1, -1) == v.simx_return_remote_error_flag
    assert "--history 0" in v.simxGetLastErrors(lab.client, BLOCKING)[1][-1]


def test_old_steps_go_after_the_seconds_and_beyond_the_memory(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    lab.history.seconds = 1.0
    lab.start()
    lab.steps(50)
    assert lab.history.steps == (30, 50)
    each = lab.history.moment(50).size
    lab.sim.limits = Limits.of([f"history={10 * each}"])
    lab.steps(30)
    first, last = lab.history.steps or (0, 0)
    assert last == 80
    assert 70 <= first <= 72
    assert lab.history.size <= 11 * each


def test_calls_have_a_bound_of_their_own_and_leave_the_steps(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    lab.sim.limits = Limits.of(["history_calls=5000"])
    lab.start()
    for number in range(20):
        v.simxSetStringSignal(lab.client, "text", bytes([number]) * 100_000, BLOCKING)
        lab.steps(1)
    assert lab.history.steps == (0, 20)
    assert functions(lab, 20) == ["simxSetStringSignal"]
    assert (functions(lab, 2), lab.history.calls(2).left_out) == ([], 1)
    assert repr(lab.history.calls(20).calls[0].arguments[1]).endswith("... (100000 bytes)")


def test_of_very_many_calls_in_a_step_the_last_are_kept_and_reading_displaces_no_others() -> None:
    log = LogOfCalls()
    for number in range(3):
        log.note("arm", "simxSetFloatSignal", ["gain", number], (0, []))
    for number in range(MOST_PER_STEP + 30):
        log.note("eye", "simxGetJointPosition", [number], (0, [0.0]), only_reads=True)
    log.note("arm", "simxSetFloatSignal", ["gain", 3], (0, []))
    step = log.take()
    assert step.left_out == 30
    assert step.has_changes
    functions = [called.function for called in step.calls]
    assert functions == ["simxSetFloatSignal"] * 3 + ["simxGetJointPosition"] * MOST_PER_STEP + [
        "simxSetFloatSignal"
    ]
    assert log.take().calls == ()


def test_long_values_are_shortened_and_what_is_kept_does_not_change() -> None:
    values = [1.0] * 3
    kept = short(values)
    values[0] = 2.0
    assert kept == [1.0, 1.0, 1.0]
    assert isinstance(short([0] * 100), Cut)
    assert repr(short(list(range(100)))).endswith("23, ... (100 items)]")
    assert repr(short("x" * 1000)) == f"{'x' * 160!r}... (1000 letters)"
    nested: list[Any] = []
    for _ in range(1000):
        nested = [nested]
    assert len(repr(short(nested))) < 100


def test_streams_are_noted_where_they_are_armed(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    lab.start()
    lab.steps(1)
    v.simxGetObjectPosition(lab.client, lab.handle("post"), -1, v.simx_opmode_streaming)
    v.simxGetPingTime(lab.client)
    lab.steps(2)
    calls = {called.function: called for called in lab.history.calls(2).calls}
    assert calls["simxGetObjectPosition"].is_stream
    assert "simxGetObjectPosition" not in functions(lab, 3), "a stream's values are no calls"


def test_an_image_is_noted_when_it_comes_and_without_its_bytes() -> None:
    log, image = LogOfCalls(), Future[Any]()
    log.note("eye", "simxGetVisionSensorImage", [14, 0], image)
    (called,) = log.take().calls
    assert called.results is None
    image.set_result((0, [[640, 480], bytes(640 * 480 * 3)]))
    resolution, pixels = cast(list[Any], called.results)
    assert resolution == [640, 480]
    assert isinstance(pixels, Cut)
    assert pixels.size == 640 * 480 * 3
    assert called.size < 1500


def test_the_embedded_clients_calls_are_noted_too(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    embedded = lab.world.embedded_client()
    lab.start()
    v.simxSetFloatSignal(embedded, "gain", 2.0, BLOCKING)
    lab.steps(1)
    (called,) = lab.history.calls(1).calls
    assert (called.client, called.function, called.arguments) == (
        "embedded",
        "simxSetFloatSignal",
        ("gain", 2.0),
    )


def test_another_scene_and_an_edit_while_stopped_end_it(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    lab.start()
    lab.steps(3)
    lab.sim.stop()
    assert lab.history.steps == (0, 3), "a stop leaves it: why did it fall?"
    code, copies = v.simxCopyPasteObjects(lab.client, [lab.handle("post")], BLOCKING)
    assert code == 0
    assert (
        v.simxGetObjectPosition(lab.client, copies[0], -1, BLOCKING)[0] == 0
    )  # the copy is in the model now
    assert lab.history.steps is None
    lab.start()
    lab.steps(2)
    lab.sim.stop()
    lab.sim.close()
    assert lab.history.steps is None


def test_the_past_is_shown_while_the_run_goes_on(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    lab.parts.scripts.add_ons[ADD_ON] = Feed(lab.loop.service, "lab", (), lab.history)
    lab.start()
    v.simxSetJointTargetPosition(lab.client, lab.handle("elbow"), 0.5, BLOCKING)
    lab.steps(4)
    then = lab.sim.data.qpos.copy()
    lab.steps(4)
    now = ask(lab.client, LOOK, -1, -1)
    past = ask(lab.client, PAST, 4, now["model"], now["arrays_version"])
    assert lab.sim.step_count == 8
    assert ask(lab.client, SURVEY, -1, -1)["past"]["now"] == ["running", pytest.approx(0.4), 8]
    assert (past["step"]["call_before"], past["step"]["call_after"]) == (1, -1)
    look = past["look"]
    assert (look["steps"], look["time"], look["model"], look["binary"]) == (4, 0.2, now["model"], None)
    assert past["step"]["joints"]["elbow"] == then[1]
    first = ask(lab.client, STEP, 1)
    assert first["calls"][-1]["call"].startswith("simxSetJointTargetPosition(")
    assert ask(lab.client, PAST, 99, -1, -1)["look"]["steps"] == 8, "the last that is kept"


def test_the_model_of_a_past_step_is_shown_after_an_edit(open_lab: Open) -> None:
    lab = open_lab(MACHINE)
    lab.parts.scripts.add_ons[ADD_ON] = Feed(lab.loop.service, "lab", (), lab.history)
    lab.start()
    lab.steps(2)
    before = ask(lab.client, LOOK, -1, -1)
    v.simxCopyPasteObjects(lab.client, [lab.handle("ball")], BLOCKING)
    lab.steps(2)
    now = ask(lab.client, LOOK, -1, -1)
    assert now["model"] != before["model"]
    past = ask(lab.client, PAST, 1, now["model"], now["arrays_version"])["look"]
    assert past["model"] == before["model"]
    assert past["binary"] is not None
    assert ask(lab.client, PAST, 4, past["model"], 0)["look"]["model"] == now["model"]


def test_a_client_that_goes_on_is_replayed_from_a_recording(tmp_path: Path) -> None:
    scene, recording = tmp_path / "machine.xml", tmp_path / "run.simxlog"
    scene.write_text(MACHINE)
    with recorded(scene, recording) as place:
        place.parts.scripts.add_ons[ADD_ON] = Feed(place.loop.service, "recorded", ())
        client = place.client()
        ask(client, KEEP, 1)
        v.simxSynchronous(client, True)
        v.simxStartSimulation(client, BLOCKING)
        for count in range(25):
            if count == 5:
                v.simxSetFloatSignal(client, "gain", 1.0, BLOCKING)
            v.simxSynchronousTrigger(client)
        gone = ask(client, GO_ON, 10)
        assert gone["step"] == 10
        v.simxStartSimulation(client, BLOCKING)
        for _ in range(25):
            v.simxSynchronousTrigger(client)
        assert place.simulation.step_count == 35
    assert replay(recording) == DONE


def test_keeping_the_past_does_not_change_a_run(open_lab: Open) -> None:
    ends = []
    for is_kept in (True, False):
        lab = open_lab(MACHINE)
        if not is_kept:
            lab.loop.service.watchers.remove(lab.history)
            lab.loop.service.executor.note_in(None)
        lab.start()
        lab.steps(10)
        v.simxSetJointTargetPosition(lab.client, lab.handle("shoulder"), -0.4, BLOCKING)
        lab.steps(20)
        ends.append(state.digests(lab.parts))
    assert ends[0] == ends[1]
