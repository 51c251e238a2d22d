"""Objects come and go: removal, models, copies, dummies; the selection (the end of the reference's 3.3)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from conforming import BLOCKING, NO_OBJECT, OK, REMOTE_ERROR, SCENE, assert_types, of
from real_world import start_stepped

import simx_client as v

ALL = v.sim_handle_all


@of("simxRemoveObject")
@pytest.mark.parametrize("runs", [False, True])
def test_a_removed_object_is_gone_and_removing_it_again_is_8(
    cid: int, simx: Any, handle: Any, runs: bool
) -> None:
    cube = handle("cube")
    if runs:
        start_stepped(cid)
    assert simx(cid, cube, BLOCKING) == OK
    assert v.simxGetObjectHandle(cid, "cube", BLOCKING) == (REMOTE_ERROR, 0)
    assert simx(cid, cube, BLOCKING) == REMOTE_ERROR
    v.simxStopSimulation(cid, BLOCKING)
    assert v.simxGetObjectHandle(cid, "cube", BLOCKING) == ((OK, cube) if runs else (REMOTE_ERROR, 0))


@of("simxRemoveObject")
def test_removing_all_leaves_nothing_and_the_selection_survives_otherwise(
    cid: int, simx: Any, handle: Any
) -> None:
    v.simxSetObjectSelection(cid, [handle("lid")], BLOCKING)
    simx(cid, handle("cube"), BLOCKING)
    assert v.simxGetObjectSelection(cid, BLOCKING) == (OK, [handle("lid")])
    assert simx(cid, ALL, BLOCKING) == OK
    assert v.simxGetObjects(cid, ALL, BLOCKING) == (OK, [])


@of("simxRemoveModel")
def test_a_model_goes_with_its_whole_tree_and_anything_else_is_8(cid: int, simx: Any, handle: Any) -> None:
    assert simx(cid, handle("lid"), BLOCKING) == REMOTE_ERROR, "no model base"
    assert simx(cid, NO_OBJECT, BLOCKING) == REMOTE_ERROR
    assert simx(cid, handle("crate"), BLOCKING) == OK
    assert v.simxGetObjectHandle(cid, "lid", BLOCKING) == (REMOTE_ERROR, 0)


_MODEL = (
    "<mujoco><worldbody><body name='toy'><geom size='0.1'/><body name='part'/></body></worldbody></mujoco>"
)


@of("simxLoadModel")
@pytest.mark.parametrize("runs", [False, True])
def test_a_model_is_added_and_its_base_returned(
    tmp_path: Path, cid: int, simx: Any, handle: Any, runs: bool
) -> None:
    (tmp_path / "toy.xml").write_text(_MODEL, encoding="utf-8")
    if runs:
        start_stepped(cid)
    code, base = simx(cid, str(tmp_path / "toy.ttm"), 0, BLOCKING)
    assert (code, base) == (OK, handle("toy"))
    assert base > max(handle(name) for name in ("lid", "cube"))
    assert v.simxGetObjectParent(cid, handle("part"), BLOCKING) == (OK, base)
    assert v.simxGetObjectSelection(cid, BLOCKING) == (OK, [base])
    assert simx(cid, "missing.ttm", 0, BLOCKING) == (REMOTE_ERROR, 0)
    assert v.simxGetObjectSelection(cid, BLOCKING) == (OK, []), "it was cleared first"


@of("simxLoadModel")
def test_a_model_file_of_the_client_is_transferred_first(
    tmp_path_factory: pytest.TempPathFactory, cid: int, simx: Any, handle: Any
) -> None:
    mine = tmp_path_factory.mktemp("client") / "toy.xml"
    mine.write_text(_MODEL, encoding="utf-8")
    assert simx(cid, str(mine), 1, BLOCKING) == (OK, handle("toy"))
    assert simx(cid, str(mine.with_name("missing.ttm")), 1, BLOCKING) == (v.simx_return_local_error_flag, 0)


@of("simxCopyPasteObjects")
def test_copies_have_new_handles_and_numbered_names_and_invalid_handles_are_skipped(
    cid: int, simx: Any, handle: Any
) -> None:
    cube = handle("cube")
    v.simxSetObjectSelection(cid, [cube], BLOCKING)
    code, copies = simx(cid, [cube, NO_OBJECT], BLOCKING)
    assert code == OK
    assert copies == [handle("cube#0")]
    assert_types(copies, [1])
    assert copies[0] > cube
    assert v.simxGetObjectSelection(cid, BLOCKING) == (OK, [cube]), "the selection is restored"
    assert simx(cid, [cube], BLOCKING) == (OK, [handle("cube#1")])
    assert simx(cid, [], BLOCKING) == (OK, [])


@of("simxCopyPasteObjects")
def test_a_copied_model_returns_only_its_base(cid: int, simx: Any, handle: Any) -> None:
    code, copies = simx(cid, [handle("crate")], BLOCKING)
    assert (code, copies) == (OK, [handle("crate#0")])
    assert v.simxGetObjectParent(cid, handle("lid#0"), BLOCKING) == (OK, copies[0])


@of("simxCreateDummy")
@pytest.mark.parametrize("color", [None, [255, 0, 0] * 4])
def test_a_dummy_is_created_at_the_origin(cid: int, simx: Any, color: Any) -> None:
    highest = max(v.simxGetObjects(cid, ALL, BLOCKING)[1])
    code, dummy = simx(cid, 0.1, color, BLOCKING)
    assert code == OK
    assert dummy > highest
    assert dummy in v.simxGetObjects(cid, v.sim_object_dummy_type, BLOCKING)[1]
    assert v.simxGetObjectPosition(cid, dummy, -1, BLOCKING) == (OK, [0.0] * 3)
    assert simx(cid, 0.1, color, BLOCKING)[1] > dummy


@of("simxCreateDummy")
@pytest.mark.parametrize("color", [None, [], [255, 0, 0], (0,) * 12])
@pytest.mark.parametrize("size", [0.1, 0, -1.0, 1e6])
def test_a_dummy_of_any_size_is_made_and_a_short_colour_filled_with_zeros(
    cid: int, simx: Any, size: float, color: Any
) -> None:
    assert simx(cid, size, color, BLOCKING)[0] == OK
    with pytest.raises(IndexError, match="at most 12"):
        simx(cid, size, [0] * 13, BLOCKING)


@of("simxGetObjectSelection")
def test_another_scene_has_nothing_selected(cid: int, simx: Any, handle: Any) -> None:
    for other in (
        lambda: v.simxLoadScene(cid, str(SCENE), 0, BLOCKING),
        lambda: v.simxCloseScene(cid, BLOCKING),
    ):
        v.simxSetObjectSelection(cid, [handle("lid")], BLOCKING)
        assert other() == OK
        assert simx(cid, BLOCKING) == (OK, [])


@of("simxGetObjectSelection")
def test_the_selection_is_a_list_of_handles(cid: int, simx: Any, handle: Any) -> None:
    assert simx(cid, BLOCKING) == (OK, [])
    v.simxSetObjectSelection(cid, [handle("lid"), handle("cube")], BLOCKING)
    assert sorted(simx(cid, BLOCKING)[1]) == sorted([handle("lid"), handle("cube")])
    assert_types(simx(cid, BLOCKING), (0, [1]))


@of("simxSetObjectSelection")
def test_the_selection_is_replaced_and_invalid_handles_ignored(cid: int, simx: Any, handle: Any) -> None:
    assert simx(cid, [handle("lid")], BLOCKING) == OK
    assert simx(cid, [handle("cube"), NO_OBJECT], BLOCKING) == OK
    assert v.simxGetObjectSelection(cid, BLOCKING) == (OK, [handle("cube")])
    assert simx(cid, [], BLOCKING) == OK
    assert v.simxGetObjectSelection(cid, BLOCKING) == (OK, [])
