"""Call-back scripts of V-REP up to 3.5, as scripts with call-back functions.

V-REP ran the whole text at each call, with the input as ``...``. Lines before and after the text make it a function,
so the numbers of its lines stay. Globals keep their values between calls.

* A joint control call-back script received whether it is the first call, whether the joint is a revolute one and
  cyclic, its handle, numbers of this and all physics steps, then position, target position, error, effort, length of
  the step, limits, target velocity, maximum force and velocity. It returned force and velocity; a joint for which it
  returned none was free. Functions in such a script were never called: V-REP called `sysCall_jointCallback` of child
  and customization scripts only. So the middle joint of the RG2 in V-REP's `ur5WithRg2Grasping` moves freely.
* A contact call-back script received the two shapes and the physics engine. It returned 0 to leave the contact to the
  engine, a negative number to ignore it, or a positive one with two tables of the engine's parameters, which do not
  apply to MuJoCo.
"""

from __future__ import annotations

import re

MAIN, CHILD, JOINT, CONTACT, CUSTOMIZATION = 0, 1, 4, 5, 6
"""Types of scripts, with the file's numbers, those of `sim_scripttype_*`."""

_CONTACT_FUNCTION = re.compile(r"\bsysCall_contactCallback\b")
_FUNCTION = re.compile(r"^\s*function\s+sysCall_\w+", re.MULTILINE)

_BEGINNING = "local function simx_body(...) "

_JOINT_END = """
end
function sysCall_jointCallback(inData)
    local force, velocity = simx_body(inData.first, inData.revolute, inData.cyclic, inData.handle, inData.passCnt,
        inData.totalPasses, inData.currentPos, inData.targetPos, inData.errorValue, inData.effort,
        inData.dynStepSize, inData.lowLimit, inData.highLimit, inData.targetVel, inData.maxForce,
        inData.velUpperLimit)
    if force == nil or velocity == nil then return {force = 0, velocity = 0} end
    return {force = force, velocity = velocity}
end
"""

_JOINT_IS_FREE = """
for name in pairs(_G) do if string.find(name, '^sysCall_') then _G[name] = nil end end
function sysCall_jointCallback() return {force = 0, velocity = 0} end
"""

_CONTACT_END = """
end
function sysCall_contactCallback(inData)
    -- Old scripts know Bullet (0), ODE and Vortex.
    local answer, integers, floats = simx_body(inData.handle1, inData.handle2, 0)
    answer = tonumber(answer) or 0
    local hasParameters = type(integers) == 'table' and type(floats) == 'table'
    if answer == 0 or (answer > 0 and not hasParameters) then return {ignoreContact = true} end
    return {ignoreContact = false, collisionResponse = answer > 0}
end
"""


def kind_of(kind: int, text: str, *, has_joint: bool) -> int:
    """Return the type of a script, which for call-backs follows from its place and text where that is clear.

    V-REP's constants have 4 for joints and 5 for contacts, but public files have scripts of type 4 that belong to no
    joint and decide about contacts.
    """
    if kind not in (JOINT, CONTACT):
        return kind
    if _CONTACT_FUNCTION.search(text):
        return CONTACT
    return JOINT if has_joint else CONTACT


def with_call_back(kind: int, text: str) -> str:
    """Return the text of a call-back script with its function; unchanged for contacts with functions, other types."""
    has_functions = _FUNCTION.search(text) is not None
    if kind not in (JOINT, CONTACT) or (kind == CONTACT and has_functions):
        return text
    if has_functions:
        return text + _JOINT_IS_FREE
    return _BEGINNING + text + (_JOINT_END if kind == JOINT else _CONTACT_END)
