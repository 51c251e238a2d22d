"""Kinematics: where joints must be for a tip to be at a target, and ways for them to get there.

**IK groups of a scene.** V-REP kept them in the scene's dialogs; here a text registers one::

    <text name="simx:ik:UR5_ik" data="tip=UR5_ikTip target=UR5_ikTarget base=UR5"/>

========== ==================== ==================================================================================
key        default              meaning
========== ==================== ==================================================================================
tip        (must be given)      object (a site will do) at the end of the chain; its whole pose counts
target     (must be given)      object the tip is brought to; best outside the chain, such as a site under the base
base       (none: the world)    object below which the joints lie that may move: a body or a site
constraints pose                pose, position, orientation, or words of x, y, z (axes of the base), alpha_beta
                                (direction of the tip's z), gamma (turn about it) with commas between them
damping    0.1                  of damped least squares; 0: pseudo inverse: exact, and nervous near singular poses
iterations 20                   at most, in each pass
handling   auto                 auto: in each pass, after the scripts' actuation and before physics; explicit: when a
                                script calls sim.handleIkGroup
========== ==================== ==================================================================================

As in V-REP, a group moves those hinges and slides between base and tip that are **in IK mode**
(``simx:joint:NAME`` with ``mode=ik``, and ``hybrid=yes`` where a motor shall do it); with no such joint it does nothing
and the log says so once. The name belongs to the group, not to an object; a model brings its groups along, and its
second copy has ``NAME#0``. Scripts use ``sim.getIkGroupHandle``, ``sim.handleIkGroup`` and the like
(``scripting/api/ik.py``), or ``simIK``, which needs no annotation.

**Why our own solver.** `mink` 1.3 with daqp was measured against it on the UR5 (200 random poses, one start, at most 50
iterations): 1.9 ms and 85 % within 0.5 mm and 0.1 degrees, against 1.2 ms and 83 % here; and scipy and the QP solvers,
which it needs, weigh 150 MB, twice MuJoCo itself. What is left is a Jacobian that MuJoCo computes and one 6 x 6 system.

`chain` finds the joints, `scratch` is the state on which all is tried (never the live one), `solver` the iteration,
`groups` the scene's groups, `environment` what `simIK` works on, `search` finds configurations from random starts.
"""

from .chain import Constraint, Element
from .groups import Group, IkGroups
from .solver import Calculation, Method, Result, Solution

__all__ = ["Calculation", "Constraint", "Element", "Group", "IkGroups", "Method", "Result", "Solution"]
