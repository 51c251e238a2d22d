"""A world after a crash of its process: another one makes it again from the journal, and it goes on bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from past_lab import MACHINE, Lab
from real_world import BLOCKING
from test_going_on import driving

import simx_client as v
from simx_server.errors import CommandError
from simx_server.files.library import find_scene
from simx_server.history.journal import Block, Journal
from simx_server.history.keeping import Keeper
from simx_server.history.recovering import Recovered, chosen_blocks, recover
from simx_server.history.writing import Kind
from simx_server.recording import state
from simx_server.scene.formats.loader import load_text
from simx_server.simulation.simulation import SimulationState

SCRIPTED = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="box" pos="0 0 1"><freejoint/><geom size="0.1"/></body>
  </worldbody>
  <custom><text name="simx:script:box" data="file=make.py"/></custom>
</mujoco>
"""
MAKE = "def sysCall_init():\n    sim.createDummy(0.1)\n"


class Crashing:
    """Servers that keep their world, and their successors."""

    def __init__(self, open_lab: Callable[[str], Lab]) -> None:
        self.open_lab = open_lab
        self.journal = Journal()
        self.ended: list[Callable[[], object]] = []

    def start(self, scene: str) -> Lab:
        lab = self.open_lab(scene)
        self._begin(lab, Keeper(lab.loop.service, self.journal))
        return lab

    def _begin(self, lab: Lab, keeper: Keeper, recovered: Recovered | None = None) -> None:
        self.keeper = keeper
        keeper.start(recovered.base if recovered else None)
        self.ended.append(lambda: lab.sim.parts.detach(keeper))

    def end(self) -> None:
        """Let no process that was started write any more."""
        while self.ended:
            self.ended.pop()()

    def again(self, lab: Lab, back: int = 0) -> tuple[Lab, Recovered]:
        """Return the successor of a lab of which nothing but the journal is left."""
        self.end()
        blocks = chosen_blocks(self.journal.read(), back)
        successor = self.open_lab(lab.scene_path)
        keeper = Keeper(successor.loop.service, self.journal)
        recovered = recover(successor.loop.service, keeper.first, blocks)
        self._begin(successor, keeper, recovered)
        return successor, recovered


@pytest.fixture
def crashing(open_lab: Callable[[str], Lab], monkeypatch: pytest.MonkeyPatch) -> Iterator[Crashing]:
    monkeypatch.setattr("simx_server.history.keeping.SHARE", 1.0)  # steps of tests are faster than real time
    one = Crashing(open_lab)
    yield one
    one.end()
    one.journal.close()


@pytest.mark.parametrize("step", [0, 1, 12, 25])
def test_a_run_goes_on_bit_for_bit_in_another_process(crashing: Crashing, step: int) -> None:
    lab = crashing.start(MACHINE)
    act = driving(lab)
    lab.start()
    lab.run_to(step, act)
    successor, recovered = crashing.again(lab)
    assert (recovered.step, recovered.state) == (step, SimulationState.RUNNING)
    rest = lab.run_to(40, act)
    successor.start()
    assert successor.run_to(40, driving(successor)) == rest


def test_a_stop_after_it_restores_what_the_first_process_had_before_the_start(crashing: Crashing) -> None:
    lab = crashing.start(MACHINE)
    post = lab.handle("post")
    v.simxSetObjectPosition(lab.client, post, -1, [1.5, 0.5, 0.5], BLOCKING)
    before = state.digests(lab.parts)
    lab.start()
    lab.run_to(10, driving(lab))
    successor, _ = crashing.again(lab)
    successor.sim.stop()
    signals = state.QUANTITIES.index("signals")
    assert state.digests(successor.parts)[:signals] == before[:signals]


def test_what_clients_do_while_it_is_stopped_or_paused_is_kept_at_the_next_look(crashing: Crashing) -> None:
    lab = crashing.start(MACHINE)
    v.simxSetFloatSignal(lab.client, "gain", 0.25, BLOCKING)
    lab.loop.look()
    stopped, recovered = crashing.again(lab)
    assert recovered.state is stopped.sim.state is SimulationState.STOPPED
    assert v.simxGetFloatSignal(stopped.client, "gain", BLOCKING) == (0, 0.25)
    stopped.start()
    stopped.run_to(3)
    stopped.sim.pause()
    v.simxSetObjectPosition(stopped.client, stopped.handle("box"), -1, [0.0, 1.0, 2.0], BLOCKING)
    stopped.loop.look()
    paused, recovered = crashing.again(stopped)
    assert (recovered.step, paused.sim.state) == (3, SimulationState.PAUSED)
    assert v.simxGetObjectPosition(paused.client, paused.handle("box"), -1, BLOCKING) == (0, [0.0, 1.0, 2.0])


def test_nothing_is_written_while_nothing_changes(crashing: Crashing) -> None:
    lab = crashing.start(MACHINE)
    lab.loop.look()
    size = crashing.journal.size
    lab.loop.look()
    assert crashing.journal.size == size


def test_objects_that_a_run_has_made_and_removed_are_there_again(crashing: Crashing) -> None:
    lab = crashing.start(MACHINE)
    lab.start()
    lab.run_to(5)
    copy = v.simxCopyPasteObjects(lab.client, [lab.handle("ball")], BLOCKING)[1][0]
    assert v.simxSetObjectPosition(lab.client, copy, -1, [0.0, -1.0, 1.0], BLOCKING) == 0
    assert v.simxRemoveObject(lab.client, lab.handle("box"), BLOCKING) == 0
    lab.run_to(8)
    successor, _ = crashing.again(lab)
    successor.start()
    assert successor.run_to(20) == lab.run_to(20)
    # The next edit works on the scene as it is, and the end of the run restores the scene of the file.
    assert v.simxCopyPasteObjects(successor.client, [copy], BLOCKING)[0] == 0
    successor.sim.stop()
    assert v.simxGetObjectHandle(successor.client, "box", BLOCKING)[0] == 0


def test_a_scene_that_a_client_has_loaded_is_there_again(crashing: Crashing) -> None:
    lab = crashing.start(MACHINE)
    lab.sim.load(find_scene("bubblerob"))
    lab.start()
    lab.run_to(5)
    successor, _ = crashing.again(lab)
    assert successor.sim.scene.name == "bubblerob"
    successor.start()
    assert successor.run_to(15) == lab.run_to(15)


def test_scripts_of_a_scene_that_a_client_sent_do_not_run_after_a_crash_either(crashing: Crashing) -> None:
    lab = crashing.start(MACHINE)
    script = "data=\"function sysCall_init() sim.setInt32Signal('mine', 1) end\""
    scene, model = load_text(f'<mujoco><custom><text name="simx:lua:main" {script}/></custom></mujoco>')
    lab.sim.use(scene, model, is_of_client=True)
    lab.loop.look()
    successor, _ = crashing.again(lab)
    assert successor.sim.scene_is_of_client
    successor.sim.start()
    assert v.simxGetIntegerSignal(successor.client, "mine", BLOCKING)[0] != 0


def test_scripts_start_again_and_make_their_objects_with_the_same_handles(
    crashing: Crashing, tmp_path: Path
) -> None:
    (tmp_path / "make.py").write_text(MAKE)
    lab = crashing.start(SCRIPTED)
    lab.start()
    lab.run_to(4)
    dummies = v.simxGetObjects(lab.client, v.sim_object_dummy_type, BLOCKING)
    successor, recovered = crashing.again(lab)
    assert recovered.step == 4
    successor.start()
    assert v.simxGetObjects(successor.client, v.sim_object_dummy_type, BLOCKING) == dummies
    assert successor.run_to(10) == lab.run_to(10)


def test_one_moment_earlier_and_the_state_before_the_run(crashing: Crashing) -> None:
    lab = crashing.start(MACHINE)
    lab.start()
    seen = lab.run_to(7)
    v.simxSetFloatSignal(lab.client, "gain", 0.25, BLOCKING)
    lab.loop.look()
    earlier, recovered = crashing.again(lab, back=1)
    assert recovered.step == 6
    earlier.start()
    assert earlier.run_to(7) == seen[6:]
    start, recovered = crashing.again(lab, back=2)
    assert (recovered.step, start.sim.state) == (0, SimulationState.STOPPED)


def test_lengths_of_steps_that_a_client_has_set_are_those_of_the_successor(crashing: Crashing) -> None:
    lab = crashing.start(MACHINE)
    lab.sim.time_step = 0.02
    lab.sim.set_physics_step(0.001)
    lab.loop.look()
    successor, _ = crashing.again(lab)
    assert (successor.sim.time_step, successor.sim.physics_step, successor.sim.substeps) == (0.02, 0.001, 20)


def test_steps_are_omitted_only_where_no_client_steps_the_simulation(
    crashing: Crashing, monkeypatch: pytest.MonkeyPatch
) -> None:
    def steps() -> list[int]:
        return [number for kind, number in crashing.journal.heads() if kind == Kind.STEP]

    lab = crashing.start(MACHINE)
    monkeypatch.setattr("simx_server.history.keeping.SHARE", 1e-9)
    monkeypatch.setattr("simx_server.history.keeping.SLOW", 10.0)
    lab.start()
    lab.run_to(3)
    assert steps() == [0, 1, 2, 3]
    lab.sim.stop()
    v.simxSynchronous(lab.client, False)
    lab.sim.start()
    lab.steps(3)
    assert steps() == [0, 1, 2, 3, 0, 1]


@pytest.mark.parametrize(("large", "kept"), [(1, [9]), (1 << 30, [7, 8, 9])])
def test_of_large_moments_only_the_last_one_is_kept(
    crashing: Crashing, monkeypatch: pytest.MonkeyPatch, large: int, kept: list[int]
) -> None:
    monkeypatch.setattr("simx_server.history.keeping.LARGE", large)
    lab = crashing.start(MACHINE)
    lab.start()
    lab.run_to(9)
    crashing.keeper._turn()
    assert [number for kind, number in crashing.journal.heads() if kind == Kind.STEP] == kept


def test_the_journal_begins_again_with_what_is_needed(
    crashing: Crashing, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simx_server.history.keeping.LEAST", 1)
    lab = crashing.start(MACHINE)
    act = driving(lab)
    lab.start()
    begun = crashing.journal.size
    lab.run_to(120, act)
    assert crashing.journal.size < 4 * begun
    successor, recovered = crashing.again(lab)
    assert recovered.step == 120
    successor.start()
    assert successor.run_to(130) == lab.run_to(130)


def test_what_was_cut_off_in_the_middle_is_left_out() -> None:
    journal = Journal()
    journal.restart([Block(Kind.SECTION, 1, b"one")])
    journal.append(Block(Kind.STEP, 5, b"five" * 100))
    journal._size -= (
        50  # the next block is written over the end of this one, as if this one was never finished
    )
    journal.append(Block(Kind.STEP, 6, b"six"))
    assert journal.read() == [Block(Kind.SECTION, 1, b"one")]
    journal.close()


def test_a_journal_that_nobody_wrote_gives_nothing() -> None:
    journal = Journal()
    assert chosen_blocks(journal.read(), 0) == []
    journal.close()


def test_what_does_not_fit_is_refused_and_leaves_a_stopped_world(crashing: Crashing) -> None:
    lab = crashing.start(MACHINE)
    lab.start()
    lab.run_to(3)
    blocks = [
        block._replace(content=block.content[:-9]) for block in chosen_blocks(crashing.journal.read(), 0)
    ]
    other = crashing.open_lab(MACHINE)
    with pytest.raises(CommandError, match="what was kept does not fit"):
        recover(other.loop.service, Keeper(other.loop.service, crashing.journal).first, blocks)
    assert other.sim.state is SimulationState.STOPPED
