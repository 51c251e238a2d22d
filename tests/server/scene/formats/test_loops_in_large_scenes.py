"""Scenes with closed loops and more degrees of freedom than MuJoCo solves with the full matrix automatically."""

from __future__ import annotations

import logging
from pathlib import Path

import mujoco
import numpy as np
import pytest

from simx_server.scene.editing.recompile import edit
from simx_server.scene.formats import jacobian
from simx_server.scene.formats.jacobian import MOST, solver_problem
from simx_server.scene.formats.loader import build
from simx_server.simulation.simulation import Simulation


def _chains(spec: mujoco.MjSpec, count: int) -> list[str]:
    """Add chains of two hinges each; return the names of their first and second links in turn."""
    places = np.random.default_rng(29)
    names: list[str] = []
    for chain in range(count):
        body = spec.worldbody
        for link in range(2):
            body = body.add_body(name=f"link{chain}.{link}", pos=places.uniform(-0.1, 0.1, 3))
            body.add_joint(
                name=f"joint{chain}.{link}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=places.normal(size=3)
            )
            body.add_geom(size=[0.02, 0, 0], mass=0.1, contype=0, conaffinity=0)
            names.append(body.name)
    return names


def _spec(chains: int, *, loops: bool = True) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    names = _chains(spec, chains)
    for other in (names[2], names[4]) if loops else ():
        spec.add_equality(
            type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=names[1],
            name2=other,
            solref=[0.005, 1],
            solimp=[0.9999, 0.9999, 0.0001, 0.5, 2],
        )
    return spec


def _scene(chains: int, *, loops: bool = True) -> mujoco.MjModel:
    return build(_spec(chains, loops=loops), None)[1]


def test_loops_that_join_several_chains_are_solved_in_a_large_scene() -> None:
    model = _scene(40)
    data = mujoco.MjData(model)
    data.qvel[:] = np.random.default_rng(0).normal(size=model.nv)
    mujoco.mj_forward(model, data)
    assert int(data.solver_niter.max()) < 5
    wanted = data.efc_aref - data.efc_R * data.efc_force
    found = np.zeros(data.nefc)
    mujoco.mj_mulJacVec(model, data, found, data.qacc)
    assert np.abs(found - wanted).max() < 1e-3 * np.abs(wanted).max()


def test_mujoco_chooses_the_matrix_of_scenes_without_loops_and_of_very_large_ones() -> None:
    for model in (_scene(40, loops=False), _scene(MOST // 2 + 1)):
        assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_AUTO


def test_a_scene_that_is_solved_wrongly_is_logged_once(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jacobian, "FIXED", mujoco.mj_version() + 1)
    spec = _spec(40)
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    spec.compile()
    scene = tmp_path / "loops.xml"
    scene.write_text(spec.to_xml(), encoding="utf-8")
    simulation = Simulation()
    with caplog.at_level(logging.WARNING):
        simulation.load(scene)
        edit(simulation, lambda _spec: None, set())
    (said,) = [each.getMessage() for each in caplog.records if "closed loops" in each.getMessage()]
    assert "this scene of 80 degrees of freedom: install mujoco 4.0.1" in said


def test_a_mujoco_whose_solver_is_right_keeps_its_choice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jacobian, "FIXED", mujoco.mj_version())
    model = _scene(40)
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_AUTO
    assert solver_problem(model) == ""


def test_no_problem_is_told_where_the_full_matrix_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jacobian, "FIXED", mujoco.mj_version() + 1)
    model = _scene(40)
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    assert solver_problem(model) == ""
    assert "4.0.1" in solver_problem(_scene(MOST // 2 + 1))
