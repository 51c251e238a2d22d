"""Parts hear of copied and scaled objects; what edits objects knows no part."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from pathlib import Path

import pytest
from handler_calls import World
from scenes_for_tests import ARM

from simx_server import editing
from simx_server.editing.copying import copy_objects
from simx_server.editing.scaling_objects import scale_object, scale_objects
from simx_server.scene.editing.copies.kept import Kept
from simx_server.simulation.part import Part


class Notes(Part):
    """A note at each of some objects."""

    def __init__(self) -> None:
        self.notes: dict[int, float] = {}
        self.asked: list[int] = []

    def copying_objects(self, handles: Collection[int]) -> None:
        self.asked.extend(handles)

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        self.notes |= {copies[handle]: note for handle, note in self.notes.items() if handle in copies}

    def object_scaled(self, handle: int, factor: float) -> None:
        if handle in self.notes:
            self.notes[handle] *= factor

    def registered_names(self) -> Mapping[str, Collection[str]]:
        return {"note": ["free"]}


@pytest.fixture
def world() -> World:
    return World(ARM)


def test_new_part_hears_of_copies_and_of_scaling(world: World) -> None:
    part = Notes()
    world.sim.parts.attach(part)
    joint = next(iter(world.sim.scene.of_kind(1)))
    part.notes[joint] = 2.0
    (copy,) = copy_objects(world.parts, [joint])
    assert part.asked == [joint]
    scale_object(world.parts, copy, [3.0, 3.0, 3.0])
    scale_objects(world.parts, [joint], 0.5, positions=False)
    assert part.notes == {joint: 1.0, copy: 6.0}
    assert list(world.sim.parts.registered_names()["note"]) == ["free"]


@pytest.mark.parametrize("module", ["copying", "grafts/grafting", "scaling_objects"])
def test_editing_names_no_part(module: str) -> None:
    text = (Path(editing.__path__[0]) / f"{module}.py").read_text()
    assert set(re.findall(r"world\.(\w+)", text)) <= {"simulation", "world"}
