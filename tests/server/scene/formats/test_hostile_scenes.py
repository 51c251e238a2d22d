"""Hostile scene files: refused with a sentence, or loaded and run; never an unforeseen error."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

import pytest
from fuzz.scenes import Loader
from seeds import many

from simx_server.errors import CommandError
from simx_server.scene.finding.references import check_references
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_scene, load_text

pytestmark = pytest.mark.slow

CASES = many(120)


@pytest.fixture(scope="module")
def loader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Loader]:
    each = Loader(tmp_path_factory.mktemp("scenes"))
    yield each
    each.close()


def test_no_scene_is_more_than_an_error(loader: Loader) -> None:
    source = random.Random(1)
    for _ in range(CASES):
        data = source.randbytes(source.choice((1, 5, 8, 14, 20, 40)))
        try:
            loader.one(data)
        except Exception as error:
            raise AssertionError(f"python tests/fuzz/run.py scenes -r {data.hex()}") from error
    assert loader.loaded > CASES / 8, "else next to nothing is tried"


@pytest.mark.parametrize("step", ["0", "nan", "-1", "1e308", "inf"])
def test_a_physics_step_that_is_none_is_refused(step: str) -> None:
    with pytest.raises(SceneError):
        load_text(
            f'<mujoco><option timestep="{step}"/><worldbody><body><joint/><geom size="1"/></body></worldbody></mujoco>'
        )


def test_a_name_that_is_not_utf_8_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "latin.xml"
    file.write_bytes(
        b'<?xml version="1.0" encoding="latin-1"?><mujoco><custom><text name="\xe9" data="a"/></custom></mujoco>'
    )
    with pytest.raises(SceneError, match="not UTF-8"):
        load_scene(file)
    with pytest.raises(CommandError, match="no well-formed XML"):
        check_references(file, [tmp_path])


@pytest.mark.parametrize(
    "bomb",
    [
        '<worldbody><replicate count="100000000"><body><geom size="1"/></body></replicate></worldbody>',
        '<worldbody><replicate count="1e9"><geom size="1"/></replicate></worldbody>',
        '<worldbody>' + '<replicate count="99">' * 4 + '<geom size="1"/>' + "</replicate>" * 4 + "</worldbody>",
        '<worldbody><body><composite type="cable" count="9000000 1 1"/></body></worldbody>',
        '<worldbody><flexcomp name="f" type="grid" count="2000 2000 2000"/></worldbody>',
        '<asset><texture name="a" builtin="flat" width="60000" height="60000"/></asset>',
        '<asset><hfield name="a" nrow="60000" ncol="60000" size="1 1 1 1"/></asset>',
    ],
)  # fmt: skip
def test_a_short_text_that_makes_a_huge_scene_is_refused_before_mujoco_reads_it(
    bomb: str, tmp_path: Path
) -> None:
    (tmp_path / "bomb.xml").write_text(f"<mujoco>{bomb}</mujoco>")
    with pytest.raises(CommandError, match="more than"):
        check_references(tmp_path / "bomb.xml", [tmp_path])
