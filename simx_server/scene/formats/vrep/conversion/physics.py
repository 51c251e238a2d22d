"""How a scene is simulated: steps, gravity, MuJoCo's solver."""

from __future__ import annotations

import math

import mujoco

from simx_server.scene.formats.annotations import PREFIX

from .context import Conversion

LONGEST = 0.005
"""Longest physics step in seconds: that of V-REP's engines."""

_SHORTEST = 0.0002

_STEPS = (0.0005, 10.0)
"""Shortest and longest simulation step in seconds."""

_USUAL_STEP = 0.05

_STRONGEST = 1e4
"""Gravity in m/s^2 above which a value is none."""


def set_physics(conversion: Conversion) -> None:
    """Set steps, gravity and solver of a scene, as the shipped scenes have them."""
    spec, settings = conversion.spec, conversion.file.settings
    step = settings.time_step
    if not _STEPS[0] <= step <= _STEPS[1]:
        step = _USUAL_STEP
    spec.add_numeric(name=f"{PREFIX}time_step", data=[step], size=1)
    option = spec.option
    option.timestep = physics_step(settings.physics_step, step)
    gravity = settings.gravity
    if all(abs(part) <= _STRONGEST for part in gravity):  # False for NaN
        option.gravity[:] = gravity
    option.integrator = int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    # Friction that holds: a block on a slope, a ball between fingers. Noslip leaves loops and couplings out of account,
    # so that a hand of several loops creeps with it unless the friction is stiff itself.
    option.cone = int(mujoco.mjtCone.mjCONE_ELLIPTIC)
    option.impratio, option.noslip_iterations = 100.0, 3
    # Things at rest cost nothing until something touches them.
    option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)


def physics_step(wanted: float, simulation_step: float) -> float:
    """Return a physics step in seconds that is a part of the simulation step, and short enough.

    Args:
        wanted: the engine's step in V-REP.
        simulation_step: the scene's.
    """
    usual = wanted if math.isfinite(wanted) and wanted > 0 else LONGEST
    longest = min(max(usual, _SHORTEST), LONGEST, simulation_step)
    return simulation_step / math.ceil(simulation_step / longest - 1e-6)
