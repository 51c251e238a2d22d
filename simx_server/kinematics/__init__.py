"""Kinematics: joint values that bring a tip to a target, and paths to reach them.

**IK groups of a scene.** V-REP kept them in the scene's dialogs; here a text registers one::

    <text name="simx:ik:UR5_ik" data="tip=UR5_ikTip target=UR5_ikTarget base=UR5"/>

========== ==================== ==================================================================================
key        default              meaning
========== ==================== ==================================================================================
tip        (required)           object (or a site) at the end of the chain; its whole pose counts
target     (required)           object that the tip is brought to; best outside the chain, such as a site under the base
                                (``world``: none yet, so the group moves nothing)
base       (none: the world)    object above the joints that may move: a body or a site
constraints pose                pose, position, orientation, or words of x, y, z (axes of the base), alpha_beta
                                (direction of the tip's z), gamma (rotation about it) with commas between them
damping    0.1                  of damped least squares; 0: pseudo inverse: exact, but unstable near singular poses
iterations 20                   maximum in each simulation step
handling   auto                 auto: in each simulation step, after the scripts' actuation and before physics;
                                explicit: when a script calls sim.handleIkGroup
========== ==================== ==================================================================================

As in V-REP, a group moves those hinges and slides between base and tip that are **in IK mode** (``simx:joint:NAME``
with ``mode=ik``, and ``hybrid=yes`` for motion by a motor); with no such joint it does nothing and the log reports
it once. The name belongs to the group, not to an object; a model brings its groups along, and its second copy has
``NAME#0``. Scripts use ``sim.getIkGroupHandle``, ``sim.handleIkGroup`` and the like (``sim_api/kinematics/ik.py``), or
``simIK``, which needs no annotation.

**Why our own solver.** `mink` 1.3 with daqp was measured against it on the UR5 (200 random poses, one start, at
most 50 iterations): 1.9 ms and 85 % within 0.5 mm and 0.1 degrees, against 1.2 ms and 83 % here in NumPy, and 0.02 ms
since it is compiled; and scipy and the QP solvers, which it needs, take 150 MB, twice as much as MuJoCo itself.

`chain` finds the joints, `scratch` is a state beside the live one, `least_squares` has the iterations in two forms,
Python and C, `solver` calls them, `groups` the scene's groups, `environment` the state that `simIK` uses, `search`
finds configurations from random starts, which `sampling` chooses and counts.
"""

from .chain import Constraint, Element
from .group import Group
from .groups import IkGroups
from .solver import Calculation, Method, Result, Solution

__all__ = ["Calculation", "Constraint", "Element", "Group", "IkGroups", "Method", "Result", "Solution"]
