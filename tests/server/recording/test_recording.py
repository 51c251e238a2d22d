"""Recordings and their replays: the same states, whatever was done; and what may go wrong with the file."""

from __future__ import annotations

import logging
import random
import shutil
import zlib
from pathlib import Path

import pytest
from busy_scene import BUSY
from processes import PENDULUM, read_line, running, server, spawn, wait_until
from real_world import BLOCKING, handle_of, start_stepped
from recordings import Actor, blocks, kinds, record_steps, recorded, replay, rewrite, send_in_one
from seeds import seeds

import simx_client as v
from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE, INCOMPLETE
from simx_client.protocol.cli.installing import extra_line
from simx_client.protocol.codec import decode_batch, encode
from simx_client.protocol.commands import TRIGGER
from simx_client.protocol.version import __version__
from simx_server.app.server import serve
from simx_server.outputs import file_thread
from simx_server.parts.add_ons import ADD_ON_TYPE
from simx_server.recording import log_file
from simx_server.recording.log_file import MAGIC, LogReader, LogWriter
from simx_server.recording.records import Kind, Record
from simx_server.settings.settings import Settings
from simx_server.simulation.simulation import SimulationState
from simx_server.viewer.feed import Feed
from simx_server.viewer.messages import ADD_ON, LOOK, ONE_STEP, SPEED, SURVEY

pytestmark = pytest.mark.slow


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    return tmp_path / "run.simxlog"


@pytest.fixture
def busy(tmp_path: Path) -> Path:
    path = tmp_path / "busy.xml"
    path.write_text(BUSY)
    return path


@pytest.fixture
def plain(tmp_path: Path) -> Path:
    path = tmp_path / "plain.xml"
    path.write_text(PENDULUM)
    return path


@pytest.mark.parametrize("seed", seeds(2))
def test_session_of_chance_stepped_and_not_replays_to_the_same_states(
    seed: int, busy: Path, recording: Path
) -> None:
    chance = random.Random(seed)
    with recorded(busy, recording) as place:
        actors = [Actor(place, seed), Actor(place, seed + 100)]
        v.simxStartSimulation(actors[0].client, BLOCKING)
        for count in range(80):
            chance.choice(actors).act()
            if count == 40:
                v.simxFinish(actors.pop().client)
                actors.append(Actor(place, seed + 200))
    assert {Kind.PASS, Kind.STATE, Kind.LEFT} <= set(kinds(recording))
    assert replay(recording) == DONE


def test_what_a_page_in_the_browser_asked_and_did_replays_to_the_same_states(
    busy: Path, recording: Path
) -> None:
    with recorded(busy, recording) as place:
        place.parts.scripts.add_ons[ADD_ON] = Feed(place.loop.service, "recorded", ())
        client, page = place.client(), place.client()
        hinge = handle_of(client, "hinge")

        def ask(function: str, *ints: int, floats: tuple[float, ...] = ()) -> None:
            code, *_ = v.simxCallScriptFunction(
                page, ADD_ON, ADD_ON_TYPE, function, ints, floats, (), b"", BLOCKING
            )
            assert code == v.simx_return_ok

        for count in range(20):
            v.simxSetJointPosition(client, hinge, 0.1 * count, BLOCKING)
            ask(LOOK, -1, -1)
            ask(ONE_STEP)
            v.simxGetPingTime(client)  # that pass is made
            ask(SURVEY, -1, -1)
            ask(SPEED, floats=(2.0 + count,))
        assert place.simulation.step_count > 10
        assert place.simulation.state is SimulationState.PAUSED
    assert Kind.PASS in kinds(recording)
    assert replay(recording) == DONE


def test_what_follows_a_trigger_in_a_message_is_replayed_after_its_step(plain: Path, recording: Path) -> None:
    with recorded(plain, recording) as place:
        client = place.client()
        hinge = handle_of(client, "hinge")
        start_stepped(client)
        (session,) = place.loop.service.clients.sessions.values()
        set_joint = ("simxSetJointPosition", hinge)
        send_in_one(place, session, (*set_joint, 0.2), (TRIGGER,), (*set_joint, 0.9))
        for _ in range(4):
            place.loop.turn()
        assert v.simxGetJointPosition(client, hinge, BLOCKING)[1] == pytest.approx(0.9)
        v.simxSynchronousTrigger(client)
    assert kinds(recording).count(Kind.WENT_ON) == 1
    assert replay(recording) == DONE


RESTLESS = """
<mujoco>
  <worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/><geom size="0.1" pos="0 0 0.1"/></body></worldbody>
  <custom><text name="simx:lua:customization:arm" data="
    function sysCall_nonSimulation()
        local hinge = sim.getObject('/hinge')
        sim.setJointPosition(hinge, sim.getJointPosition(hinge) + 0.01)
    end"/></custom>
</mujoco>
"""


def test_what_went_on_while_the_simulation_stood_still_is_replayed(tmp_path: Path, recording: Path) -> None:
    (tmp_path / "restless.xml").write_text(RESTLESS)
    with recorded(tmp_path / "restless.xml", recording) as place:
        client = place.client()
        hinge = handle_of(client, "hinge")
        moved = lambda: v.simxGetJointPosition(client, hinge, BLOCKING)[1] > 0.025  # noqa: E731
        assert wait_until(moved, 20.0)
        start_stepped(client)
        v.simxSynchronousTrigger(client)
    assert kinds(recording).count(Kind.IDLE) > 2
    assert replay(recording) == DONE


LONG = """
<mujoco>
  <worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/><geom size="0.1" pos="0 0 0.1"/></body></worldbody>
  <custom><text name="simx:lua:arm" data="
    function work(times)
        local sum = 0
        for round = 1, times[1] do
            for i = 1, 300000 do sum = sum + 1 end
            local target = sim.getFloatSignal('target')
            if target then sim.setJointPosition(sim.getObject('/hinge'), 0.1 * round + target) end
        end
        return {}, {}, {}, ''
    end
    function sysCall_actuation() work({5}) end"/></custom></mujoco>
"""


@pytest.mark.parametrize("within", ["a call", "a pass"])
def test_calls_that_came_while_a_script_ran_are_replayed_where_it_noticed_them(
    within: str, tmp_path: Path, recording: Path
) -> None:
    (tmp_path / "long.xml").write_text(LONG)
    with recorded(tmp_path / "long.xml", recording) as place:
        client, other = place.client(), place.client()
        start_stepped(client)
        _, other_session = place.loop.service.clients.sessions.values()
        serve, count = place.loop.service.meanwhile.serve_others, 0

        def send_and_serve() -> None:
            nonlocal count
            count += 1
            send_in_one(place, other_session, ("simxSetFloatSignal", "target", 0.001 * count))
            serve()

        place.simulation.interruptions.serve_others = send_and_serve
        for _ in range(3):
            if within == "a pass":
                v.simxSynchronousTrigger(client)
            else:
                script = (1, "work", [8], [], [], b"")
                assert v.simxCallScriptFunction(client, "arm", *script, BLOCKING)[0] == v.simx_return_ok
        v.simxFinish(other)
    points = [record[1] for record in LogReader(recording) if record[0] == Kind.BATCH]
    assert len([point for point in points if point >= 0]) > 3
    assert replay(recording) == DONE


def test_files_that_are_not_there_any_more_are_in_the_recording(tmp_path: Path, recording: Path) -> None:
    folder = tmp_path / "robot"
    (folder / "parts").mkdir(parents=True)
    (folder / "main.xml").write_text(
        '<mujoco><compiler meshdir="parts"/><include file="parts/arm.xml"/>'
        '<asset><mesh name="m" file="tetra.obj"/></asset>'
        '<custom><text name="simx:script:arm" data="file=turn.lua"/></custom></mujoco>'
    )
    (folder / "parts" / "arm.xml").write_text(
        '<mujoco><worldbody><body name="arm"><joint name="hinge" axis="0 0 1"/>'
        '<geom type="mesh" mesh="m"/></body></worldbody></mujoco>'
    )
    (folder / "parts" / "tetra.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    )
    (folder / "turn.lua").write_text(
        "local speed = require 'speed'\n"
        "function sysCall_actuation() sim.setJointTargetVelocity(sim.getObject('/hinge'), speed) end"
    )
    (folder / "speed.lua").write_text("return 0.7")
    (tmp_path / "box.xml").write_text(
        '<mujoco><worldbody><body name="box" pos="0 0 1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
    )
    with recorded(folder / "main.xml", recording) as place:
        client = place.client()
        code, box = v.simxLoadModel(client, str(tmp_path / "box.xml"), 0, BLOCKING)
        assert code == v.simx_return_ok
        v.simxSetObjectPosition(client, box, -1, (0, 0, 2), BLOCKING)
        start_stepped(client)
        for _ in range(25):
            v.simxSynchronousTrigger(client)
        v.simxStopSimulation(client, BLOCKING)
        (tmp_path / "box.xml").write_text((tmp_path / "box.xml").read_text().replace("0.1", "0.2"))
        assert v.simxLoadScene(client, "box.xml", 0, BLOCKING) == v.simx_return_ok
        start_stepped(client)
        v.simxSynchronousTrigger(client)
    shutil.rmtree(folder)
    (tmp_path / "box.xml").unlink()
    assert replay(recording) == DONE
    assert sorted(path.name for path in tmp_path.iterdir()) == [recording.name]


def test_replay_that_differs_says_where_and_in_what(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    record_steps(plain, recording)

    def change(records: list[Record]) -> list[Record]:
        passes = 0
        for record in records:
            passes += record[0] == Kind.PASS
            if passes == 11 and record[0] == Kind.BATCH:
                batch = decode_batch(record[3])
                call = batch.calls[0]
                if call.command == "simxSetJointTargetVelocity":
                    other = call._replace(arguments=[call.arguments[0], 5.0])
                    record[3] = encode(batch._replace(calls=[other]))
        return records

    rewrite(recording, change)
    assert replay(recording) == DIVERGED
    told = caplog.messages[-1]
    assert "differs in pass 12 of the recording, 0.600 s after the start of that run: other" in told
    assert "velocities (qvel)" in told


def test_replay_that_cannot_make_a_pass_says_so(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    record_steps(plain, recording)
    rewrite(recording, lambda records: [each for each in records if each[0] != Kind.BATCH])
    assert replay(recording) == DIVERGED
    assert "the simulation is stopped, or waits for a trigger" in caplog.messages[-1]


def test_recording_of_another_mujoco_is_replayed_with_a_warning(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    record_steps(plain, recording, passes=2)

    def change(records: list[Record]) -> list[Record]:
        records[0][1]["mujoco"] = "2.0.0"
        return records

    rewrite(recording, change)
    assert replay(recording) == DONE
    assert "recorded with mujoco 2.0.0, replayed with" in caplog.text


def test_recording_of_an_older_server_is_replayed_with_a_warning_of_what_may_differ(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    record_steps(plain, recording, passes=2)
    assert replay(recording) == DONE
    assert "older server" not in caplog.text

    def change(records: list[Record]) -> list[Record]:
        del records[0][1]["behaviour"]
        return records

    rewrite(recording, change)
    assert replay(recording) == DONE
    assert f"version {__version__}, which made the recording, replays it bit for bit" in caplog.text


def test_code_of_clients_is_replayed_only_when_that_is_allowed_again(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with recorded(plain, recording, allow_code=True):
        pass
    assert replay(recording) == FAILURE
    assert "add --allow-code if you trust it" in caplog.text
    assert replay(recording, allow_code=True) == DONE


def test_xacro_of_a_recording_is_expanded_only_when_code_is_allowed(
    tmp_path: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Its expressions are programs, and a recording may come from anybody."""
    pytest.importorskip("xacro", reason=extra_line("urdf"))
    robot = tmp_path / "robot.urdf"
    robot.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="x" value="0.2"/>'
        '<link name="a"><collision><geometry><box size="${x} 1 1"/></geometry></collision></link></robot>'
    )
    with recorded(robot, recording):
        pass
    assert replay(recording) == FAILURE
    assert "has the xacro file 'robot.urdf', whose expressions are programs" in caplog.text
    assert replay(recording, allow_code=True) == DONE


def test_recording_that_was_torn_off_anywhere_is_replayed_as_far_as_it_goes(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    record_steps(plain, recording, passes=4)
    made = blocks(list(LogReader(recording)))
    for count in range(1, len(made)):
        head = MAGIC + b"".join(made[:count])
        damage = (b"", made[count][:5], made[count][:-1], made[count][:-1] + b"x", bytes(100))[count % 5]
        recording.write_bytes(head + damage)
        has_state = count > 1  # of the first block, with the files, nothing can be compared
        assert replay(recording) == (INCOMPLETE if damage or not has_state else DONE)
        told = caplog.messages[-1]
        assert ("is equal" in told) == (has_state and not damage)
        assert "the recording goes no further: " in told
        assert (f"begins at byte {len(head)} is torn off or damaged" in told) == bool(damage)
    for rest in (b"", made[0][:-1]):
        recording.write_bytes(MAGIC + rest)
        assert replay(recording) == FAILURE
        assert "it was cut before its first block was written" in caplog.messages[-1]


def test_recording_with_a_flipped_byte_is_never_equal(plain: Path, recording: Path) -> None:
    record_steps(plain, recording, passes=4)
    whole = recording.read_bytes()
    source = random.Random(7)
    for place in [*range(len(MAGIC) + 8), *sorted(source.sample(range(len(whole)), 12)), len(whole) - 1]:
        flipped = bytearray(whole)
        flipped[place] ^= 1 << source.randrange(8)
        recording.write_bytes(flipped)
        assert replay(recording) in (FAILURE, INCOMPLETE)
    recording.write_bytes(whole)
    assert replay(recording) == DONE


def test_recording_of_which_nothing_can_be_compared_is_not_equal(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with recorded(plain, recording) as place:
        v.simxSetIntegerSignal(place.client(), "seen", 1, BLOCKING)
    assert replay(recording) == DONE  # its last state was compared
    rewrite(recording, lambda records: [each for each in records if each[0] != Kind.STATE])
    assert replay(recording) == INCOMPLETE
    assert "the recording holds no state to compare with" in caplog.messages[-1]


def test_recording_whose_last_state_differs_is_told_though_no_pass_was_made(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with recorded(plain, recording) as place:
        v.simxSetIntegerSignal(place.client(), "seen", 1, BLOCKING)
    rewrite(recording, lambda records: [each for each in records if each[0] != Kind.BATCH])
    assert replay(recording) == DIVERGED
    assert "other signals" in caplog.messages[-1]


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "is no recording: those begin with 'simxlog 1'"),
        (b"<mujoco/>", "is no recording"),
        (b"simxlog 9\n", "in another format; this server reads 'simxlog 1'"),
        (
            MAGIC + b"\x01\0\0\0" + zlib.crc32(b"\x07").to_bytes(4, "little") + b"\x07",
            "something else than records",
        ),
        (MAGIC + b"".join(blocks([[Kind.HEADER, {}], [Kind.IDLE]])), "header is not complete"),
        (
            MAGIC + b"".join(blocks([[Kind.HEADER, {"scene": "/../x", "workspace": "/"}], [Kind.IDLE]])),
            "no recorder",
        ),
    ],
)
def test_file_that_is_no_recording_is_told_in_a_sentence(
    content: bytes, told: str, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    recording.write_bytes(content)
    assert replay(recording) == FAILURE
    assert told in caplog.messages[-1]


def test_recording_that_cannot_be_written_is_told_before_the_server_starts(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    recording.write_bytes(b"precious")
    for path, told in (
        (recording, "exists already and is not written over"),
        (Path("/dev/full"), "No space left"),
    ):
        assert serve(Settings(scene=str(plain), record=path, ports=(0,))) == FAILURE
        assert told in caplog.messages[-1]
    assert recording.read_bytes() == b"precious"


def test_disk_that_is_too_slow_ends_the_recording_and_takes_no_more_memory(
    recording: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_file, "MOST_WAITING", 10_000)
    writer = log_file.LogWriter(recording)
    for _ in range(100):
        writer.put(Kind.FOUND, "x" * 1000, False, "")
    assert "ends here: the disk is too slow" in caplog.messages[-1]
    writer.close()
    assert len(writer._waiting) == 0
    assert len(kinds(recording)) <= 100
    assert recording.stat().st_mode & 0o077 == 0


def test_server_that_is_killed_leaves_a_recording_of_all_but_the_last_second(
    plain: Path, recording: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    with server(plain, "--record", recording, "--workspace", recording.parent) as process:
        client = v.simxStart("127.0.0.1", process.port, True, True, 5000, 5)
        v.simxStartSimulation(client, BLOCKING)  # in real time
        v.simxSetIntegerSignal(client, "before", 1, BLOCKING)
        assert wait_until(lambda: b"before" in recording.read_bytes(), 20.0)
        v.simxSetIntegerSignal(client, "after", 1, BLOCKING)
        process.kill()
        v.simxFinish(client)
    assert Kind.END not in kinds(recording)
    assert replay(recording) == DONE
    assert "the recording goes no further" in caplog.messages[-1]


def test_server_that_is_killed_when_it_is_ready_leaves_a_recording_of_its_start(
    plain: Path, recording: Path
) -> None:
    with server(plain, "--record", recording, "--workspace", recording.parent, "--start") as process:
        process.kill()
    assert {Kind.HEADER, Kind.STARTED} <= set(kinds(recording))


def test_records_are_written_at_once_on_request(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file_thread, "PERIOD", 1e6)
    writer = LogWriter(recording)
    writer.put(Kind.HEADER, {})
    writer.write_out()
    assert kinds(recording) == [Kind.HEADER]
    monkeypatch.setattr(writer._file, "write", lambda _content: _raise(OSError(28, "full")))
    writer.put(Kind.FOUND, "x", False, "")
    writer.write_out()  # returns, although nothing is written any more
    writer.close()
    assert writer.has_failed


def _raise(error: Exception) -> None:
    raise error


FULL_DISK = """
import resource, sys
from simx_server.app.cli import main
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
sys.exit(main())
"""


def test_full_disk_ends_the_recording_and_not_the_server(
    plain: Path, recording: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with running(spawn("-c", FULL_DISK, plain, "--port", "0", "--record", recording)) as process:
        ready = read_line(process)
        port = int(ready.partition("127.0.0.1:")[2].split()[0])
        client = v.simxStart("127.0.0.1", port, True, True, 5000, 5)
        start_stepped(client)
        v.simxSynchronousTrigger(client)
        recorded_by_then = lambda: b"Trigger" in recording.read_bytes()  # noqa: E731
        assert wait_until(recorded_by_then, 20.0)
        v.simxSetStringSignal(client, "long", random.Random(0).randbytes(200_000), BLOCKING)
        told: list[str] = []
        assert wait_until(lambda: told.append(capfd.readouterr().err) or "ends here" in "".join(told), 20.0)
        assert v.simxSynchronousTrigger(client) == v.simx_return_ok
        v.simxFinish(client)
    assert "File too large" in "".join(told)
    assert replay(recording) == DONE
