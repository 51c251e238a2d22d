"""CoppeliaSim's class IK: worlds of inverse kinematics, which the server has. The functions of simIK stay."""

import sys
from importlib import import_module

import simIK
from sim_objects import HANDLE_APP

_RENAMED = {
    "constraint_alphabeta": "constraint_alpha_beta",
    "calc_outoftolerance": "calc_notwithintolerance",
    "calc_largesteps": "calc_stepstoobig",
    "calc_boundshit": "calc_limithit",
}


class _IK:
    """The class: ``IK()``, ``IK.constraint_pose``."""

    def __call__(self):
        return import_module("sim-2").callMethod(HANDLE_APP, "IK")

    def __getattr__(self, name):
        return getattr(simIK, _RENAMED.get(name, name))


sys.modules[__name__] = _IK()
