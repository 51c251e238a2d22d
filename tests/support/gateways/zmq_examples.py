"""A scene with what the official examples of the ZeroMQ remote API name: robots, targets, sensors, scripts.

CoppeliaSim has several scenes for them; here all is in one, in a row along y.
"""

from __future__ import annotations

from xml.sax.saxutils import escape

SEQUENCES = """
sim = require('sim')
local sequences, queue = {}, {}

function sysCall_init()
    joints = {}
    for i = 0, 5 do joints[i + 1] = sim.getObject('./joint', {index = i}) end
end

function remoteApi_movementDataFunction(data)
    sequences[data.id] = data
end

function remoteApi_executeMovement(id)
    queue[#queue + 1] = id
end

function apply(positions)
    for i = 1, 6 do sim.setJointPosition(joints[i], positions[i]) end
end

local function followPoints(data)
    local columns = {data.j1, data.j2, data.j3, data.j4, data.j5, data.j6}
    for i = 1, #data.times do
        local positions = {}
        for j = 1, 6 do positions[j] = columns[j][i] end
        apply(positions)
        sim.step()
    end
end

function sysCall_thread()
    sim.setStringSignal('/blueArm_executedMovId', 'ready')
    while true do
        local id = table.remove(queue, 1)
        if id then
            local data = sequences[id]
            if data.type == 'pts' then
                followPoints(data)
            else
                local now, jerk = {}, {}
                for i = 1, 6 do now[i] = sim.getJointPosition(joints[i]) jerk[i] = 100 end
                sim.moveToConfig(-1, now, nil, nil, data.maxVel, data.maxAccel, jerk, data.targetConfig, data.targetVel,
                    apply)
            end
            sim.setStringSignal('/blueArm_executedMovId', id)
        end
        sim.step()
    end
end
"""


def arm(name: str, place: str, joints: int, alias: str = "joint") -> tuple[str, str]:
    """Return an arm as MJCF: its body with a tip, and its annotations.

    Its joints are passive and turn about z and y by turns; each has the alias in CoppeliaSim's manner.

    Args:
        name: of the base.
        place: x, y, z in metres.
        joints: how many.
        alias: of each joint.
    """
    body, notes = f'<site name="{name}_tip" pos="0 0 0.15"/>', [_alias(f"{name}_tip", "tip")]
    for number in range(joints, 0, -1):
        axis = "0 0 1" if number % 2 else "0 1 0"
        body = (
            f'<body name="{name}_link{number}" pos="0 0 0.15"><joint name="{name}_joint{number}" axis="{axis}"/>'
            f'<geom type="capsule" fromto="0 0 0 0 0 0.1" size="0.02" contype="0" conaffinity="0"/>{body}</body>'
        )
        notes += [
            _alias(f"{name}_joint{number}", alias),
            _note("joint", f"{name}_joint{number}", "mode=passive"),
        ]
    return f'<body name="{name}" pos="{place}"><geom size="0.03"/>{body}</body>', "".join(notes)


def _note(kind: str, name: str, data: str) -> str:
    return f'<text name="simx:{kind}:{name}" data="{data}"/>'


def _alias(name: str, alias: str) -> str:
    return _note("object", name, f"alias={alias}")


ARMS = [
    arm("blueRobot", "0 1 0", 7),
    arm("redRobot", "0 2 0", 7),
    arm("blueArm", "0 3 0", 6),
    arm("LBR4p", "0 4 0", 7, alias="j"),
]

SCENE = f"""
<mujoco model="examples">
  <option timestep="0.005" gravity="0 0 -9.81"/>
  <visual><headlight ambient="0.1 0.2 0.3"/></visual>
  <worldbody>
    <geom name="Floor" type="plane" size="5 5 0.1"/>
    {"".join(body for body, _ in ARMS)}
    <site name="LBR4p_target" pos="0.3 4 0.6"/>
    <body name="greenRobot" pos="0 5 0"><geom size="0.03"/><site name="greenRobot_target" pos="0.2 0 0.4"/></body>
    <body name="Cuboid" pos="0 6 1"><geom type="box" size="0.05 0.05 0.05"/>
      <body name="pendulum"><joint name="Cuboid_joint" axis="0 0 1" armature="0.01"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.01" mass="0.2" contype="0" conaffinity="0"/></body></body>
    <body name="StartConfiguration" pos="-0.4 0 0.1"><geom type="box" size="0.05 0.05 0.05"/></body>
    <body name="GoalConfiguration" pos="0.4 0 0.1"><geom type="box" size="0.05 0.05 0.05" contype="0" conaffinity="0"/>
    </body>
    <camera name="VisionSensor" pos="1 0 1" euler="0.5 0 0" resolution="16 8"/>
    <camera name="PassiveVisionSensor" pos="2 0 1" resolution="16 8"/>
  </worldbody>
  <actuator><velocity name="Cuboid_motor" joint="Cuboid_joint" kv="10"/></actuator>
  <custom>
    {"".join(notes for _, notes in ARMS)}
    {_alias("LBR4p_target", "target")}{_alias("greenRobot_target", "target")}{_alias("Cuboid_joint", "joint")}
    {_note("vision", "PassiveVisionSensor", "external=yes")}
    <text name="simx:lua:blueArm" data="{escape(SEQUENCES, {chr(10): "&#10;"})}"/>
  </custom>
</mujoco>
"""
