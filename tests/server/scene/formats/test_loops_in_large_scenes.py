"""Scenes with closed loops and more degrees of freedom than MuJoCo solves with the full matrix automatically."""

from __future__ import annotations

import mujoco
import numpy as np

from simx_server.scene.formats.jacobian import MOST
from simx_server.scene.formats.loader import build


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


def _scene(chains: int, *, loops: bool = True) -> mujoco.MjModel:
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
    return build(spec, None)[1]


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
