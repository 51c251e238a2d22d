"""Make the world of a journal again, in another process than the one that wrote it.

The scene is the one that both have loaded, or comes from the journal. A run is started as `going_on` does it: its
scripts start, then the world is set to the moment. So what scripts know in their variables is lost, and physics
continues bit for bit.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco

from simx_server.errors import CommandError
from simx_server.joints.moments import Moment as JointsMoment
from simx_server.scene.editing.model_state import editable_arrays, options_of
from simx_server.scene.objects import Scene
from simx_server.simulation.parts import Memories
from simx_server.simulation.saved_state import Snapshot
from simx_server.simulation.simulation import Simulation, SimulationState

from .going_on import start_from
from .journal import Block
from .models import unpack_model
from .moments import Moment, Structure, restore
from .packing import NotPackable, unpack
from .writing import FIELDS, FIELDS_OF_JOINTS, First, Kind, Run

if TYPE_CHECKING:
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Recovered:
    """The world was made again."""

    base: Moment
    """The state before the run, or the present one while no run exists."""

    state: SimulationState
    step: int
    time: float


def chosen_blocks(blocks: Sequence[Block], back: int) -> list[Block]:
    """Return the blocks from which the world is made again; none if there are too few.

    Args:
        blocks: all of a journal.
        back: 0 for the last moment, 1 for the one before it, 2 for the state before the run.
    """
    sections = [block for block in blocks if block.kind == Kind.SECTION]
    worlds = [place for place, block in enumerate(blocks) if block.kind != Kind.SECTION]
    bases = [place for place in worlds if blocks[place].kind == Kind.STOPPED]
    if not bases:
        return []
    base = bases[-1]
    run = [blocks[place] for place in worlds if place > base]
    if back == 1:
        last = run[-1].number if run else 0
        while run and run[-1].number == last:  # calls between two steps change the same step
            run.pop()
    return _without_unused([*sections, blocks[base], *(run[-2:] if back < 2 else [])])


def _without_unused(blocks: Sequence[Block]) -> list[Block]:
    """Leave out the sections that no moment refers to."""
    contents = {block.number: block.content for block in blocks if block.kind == Kind.SECTION}
    used: set[int] = set()
    for block in blocks:
        if block.kind != Kind.SECTION:
            sections, memories, *_ = unpack(block.content)
            used |= {*sections, *memories}
            structure = unpack(contents[sections[0]])
            used |= {*structure["arrays"], *(() if structure["model"] is None else (structure["model"],))}
    return [block for block in blocks if block.kind != Kind.SECTION or block.number in used]


def recover(service: Service, first: First, blocks: Sequence[Block]) -> Recovered:
    """Set a world that has just been loaded, and is stopped, to the last moment of these blocks.

    Args:
        first: the scene as it was loaded.
        blocks: as `chosen_blocks` returns them.

    Raises:
        CommandError: this is not possible; the world is stopped.
    """
    sim = service.simulation
    try:
        reader = _Reader(service, first, blocks)
        *_, base = (block for block in blocks if block.kind == Kind.STOPPED)
        run = [block for block in blocks if block.kind == Kind.STEP]
        before, run_of_base = reader.moment(base)
        if before.structure.snapshot.scene is not sim.scene:
            # Its scripts must not run if a client sent them.
            sim.use(before.structure.snapshot.scene, before.model, is_of_client=run_of_base[3])
        _set_steps(sim, run_of_base)
        restore(service.world, before, None)
        if not run:
            return Recovered(before, sim.state, 0, 0.0)
        moments = [reader.moment(block) for block in run]
        moment, of_run = moments[-1]
        earlier = moments[-2][0] if len(moments) > 1 and moments[-2][0].step == moment.step - 1 else None
        start_from(service, moment, earlier, before.next_handle)
        if of_run[0] == SimulationState.PAUSED.value:
            sim.pause()
        return Recovered(before, sim.state, moment.step, sim.time)
    except (NotPackable, LookupError, TypeError, ValueError, AttributeError, mujoco.FatalError) as error:
        sim.stop()
        raise CommandError(f"what was kept does not fit: {' '.join(str(error).split())}") from error


def clients_of(blocks: Sequence[Block]) -> dict[str, tuple[str, bool]]:
    """Return the clients at the last moment: id to name, and whether the client stepped the simulation."""
    *_, (*_, clients) = unpack(blocks[-1].content)
    return clients


def _set_steps(sim: Simulation, run: Run) -> None:
    _, time_step, physics_step, _, _ = run
    if sim.time_step != time_step or sim.physics_step != physics_step:
        sim.time_step = max(time_step, physics_step)
        sim.set_physics_step(physics_step)
        sim.time_step = time_step


class _Reader:
    """Makes moments of blocks."""

    def __init__(self, service: Service, first: First, blocks: Sequence[Block]) -> None:
        self._sim = service.simulation
        self._first = first
        self._contents = {block.number: block.content for block in blocks if block.kind == Kind.SECTION}
        self._made: dict[int, Any] = {}
        self._models: dict[int | None, tuple[Scene, mujoco.MjModel, mujoco.MjData]] = {
            None: (first.scene, first.model, self._sim.data)
        }

    def moment(self, block: Block) -> tuple[Moment, Run]:
        """Return a moment, and what belongs to its run."""
        sections, memories, fields, run = unpack(block.content)
        structure, signals, bindings, weights, values, names = sections
        others = len(FIELDS)
        joints = JointsMoment(
            bindings=self._section(bindings),
            values=self._section(values),
            weights=self._section(weights),
            new=0,
            **dict(zip(FIELDS_OF_JOINTS, fields[others:], strict=True)),
        )
        moment = Moment(
            structure=self._structure(structure),
            joints=joints,
            signals=self._section(signals),
            parts=self._memories(self._section(names), memories),
            size=0,
            **dict(zip(FIELDS, fields[:others], strict=True)),
        )
        return moment, run

    def _section(self, number: int) -> Any:
        if number not in self._made:
            self._made[number] = unpack(self._contents[number])
        return self._made[number]

    def _memories(self, names: Sequence[str], memories: Sequence[int]) -> Memories:
        parts = self._sim.parts.remembering
        if [*names] != [type(part).__name__ for part in parts]:
            raise NotPackable("it is of a server with other parts")
        return [(part, self._section(number)) for part, number in zip(parts, memories, strict=True)]

    def _structure(self, number: int) -> Structure:
        key = ~number
        if key in self._made:
            return self._made[key]
        kept: dict[str, Any] = unpack(self._contents[number])
        if (place := kept["model"]) not in self._models:
            scene, model = unpack_model(self._contents[place])
            self._models[place] = scene, model, mujoco.MjData(model)
        scene, model, data = self._models[place]
        arrays = [self._contents[content] for content in kept["arrays"]]
        if list(map(len, arrays)) != [value.nbytes for _, value in editable_arrays(model)]:
            raise ValueError("arrays of another model")
        annotations = scene.annotations if kept["annotations"] is None else kept["annotations"]
        snapshot = Snapshot(
            scene=scene,
            model=model,
            data=data,
            state=data.qpos,  # not used, as the docstring of `Structure` says
            arrays=arrays,
            options=options_of(kept["options"]),
            parents=kept["parents"],
            identities={
                handle: (name, alias, scene.objects[handle].annotations if notes is None else notes)
                for handle, (name, alias, notes) in kept["identities"].items()
            },
            annotations=annotations,
            overrides=kept["overrides"],
            model_properties=kept["model_properties"],
            withheld=kept["withheld"],
            joints=self._sim.joints.remember(),
        )
        gravity = kept["options"]["gravity"].tobytes()
        self._made[key] = Structure(snapshot, self._sim.model_version, gravity, 0)
        return self._made[key]
