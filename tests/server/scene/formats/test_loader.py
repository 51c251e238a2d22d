"""Reading a scene file: what is changed on the way, and what is said about it."""

from __future__ import annotations

import mujoco
import pytest

from simx_server.scene.formats.loader import load_text


@pytest.mark.parametrize("integrator", ["Euler", "RK4"])
def test_explicit_integrators_are_replaced_as_stiff_motors_break_them(integrator: str) -> None:
    _, model = load_text(f'<mujoco><option integrator="{integrator}"/></mujoco>')
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST


def test_implicit_integrators_are_kept() -> None:
    _, model = load_text('<mujoco><option integrator="implicit"/></mujoco>')
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICIT


def test_what_mujoco_warns_of_goes_to_the_log(caplog: pytest.LogCaptureFixture) -> None:
    load_text(
        "<mujoco><compiler settotalmass='2'/><worldbody><body><geom size='1'/></body></worldbody></mujoco>"
    )
    assert "mujoco: compiler attribute 'settotalmass' is deprecated" in caplog.text
