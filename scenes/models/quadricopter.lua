-- Flies the Quadricopter: its base goes to where the green target is, and turns as the target is turned.
--
-- Clients move `Quadricopter_target`; at the start it is let go, so that it does not fly along.
-- Once a pass, from outside to inside: the wanted acceleration from the error of place and speed; from that the wanted
-- direction of the thrust; the turn towards it; four rotor thrusts, which act until the next pass. The inner loop has
-- its gains computed for the length of the pass, since at 50 ms it is sampled hardly faster than the body can turn.

local GRAVITY = 9.81            -- m/s2
local MASS = 0.52               -- kg: bar 0.12 and rotors 4 x 0.1
local INERTIA = {0.00404, 0.00494, 0.00892}     -- kg m2 about the body's axes, of the same parts
local ARM = 0.0919              -- m, of each rotor along x and along y
local DRAG = 0.03               -- N m of reaction about the axis per N of thrust
local ROTOR_MAX = 3             -- N; hovering takes 1.3
local YAW_SHARE = 0.35          -- N that a rotor may spare for turning about the vertical

local PLACE_RATE = 3.0          -- 1/s: how fast an error of place goes away
local TILT_RATE = 20            -- 1/s: the same for the direction of the thrust,
local YAW_RATE = 3.5            -- 1/s: and for the heading, on which the rotors act but weakly
local LEARN_RATE = 0.7          -- 1/s: of what a load or a wind needs
local SETTLED = 0.12            -- m/s: faster, an error is an approach and no load
local FARTHEST = 1.5            -- m: a target farther off is gone to as if it were so near, hence at 2.2 m/s
local TARGET_SPEED = 1.5        -- m/s: a faster one is a jump, which is not to be followed as a motion
local TARGET_MEMORY = 0.1       -- s over which the target's speed is averaged: it may be moved every few passes only
local TILT_MAX = math.tan(math.rad(30))
local CLIMB_MAX = 5             -- m/s2, up and down

-- Rotors: where they are, and which way the reaction on the body turns.
local ROTORS = {{1, 1, 1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, -1}}
local BLADE_TURN = 2.4          -- rad a pass, for the eye

local body, base, target
local respondables, joints = {}, {}
local wanted_speed, trim = {0, 0, 0}, {0, 0, 0}
local last_place                -- of the target
local pushed, turned = {0, 0, 0}, {0, 0, 0}     -- accelerations of the last pass, as they were meant

local function limited(value, limit)
    return math.max(-limit, math.min(limit, value))
end

-- Columns of the rotation matrix of a quaternion (x, y, z, w): the body's axes in the world.
local function axes_of(q)
    local x, y, z, w = q[1], q[2], q[3], q[4]
    return {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
        {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
        {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}
end

local function dot(a, b)
    return a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
end

-- Gains of error and rate that give a body turned by constant torques from pass to pass two equal poles exp(-rate dt).
local function gains(rate, dt)
    local p = math.exp(-rate * dt)
    return (1 - p) ^ 2 / dt ^ 2, (3 - 2 * p - p * p) / (2 * dt)
end

-- What the speed measured over the last pass has become at its end.
local function now(mean, acceleration, dt)
    return mean + acceleration * dt / 2
end

local function wanted_acceleration(dt)
    local place, goal = sim.getObjectPosition(base, -1), sim.getObjectPosition(target, -1)
    local speed = sim.getObjectVelocity(body)
    local keep = math.exp(-dt / TARGET_MEMORY)
    local wanted = {}
    for i = 1, 3 do
        local moved = limited((goal[i] - last_place[i]) / dt, TARGET_SPEED)
        wanted_speed[i] = keep * wanted_speed[i] + (1 - keep) * moved
        local gap = limited(goal[i] - place[i], FARTHEST)
        local slip = wanted_speed[i] - now(speed[i], pushed[i], dt)
        if math.abs(wanted_speed[i] - speed[i]) < SETTLED then
            trim[i] = limited(trim[i] + LEARN_RATE * PLACE_RATE ^ 2 * limited(gap, 0.2) * dt, 4)
        end
        wanted[i] = PLACE_RATE ^ 2 * gap + 2 * PLACE_RATE * slip + trim[i]
    end
    last_place = goal
    wanted[3] = limited(wanted[3], CLIMB_MAX)
    local level = math.sqrt(wanted[1] ^ 2 + wanted[2] ^ 2)
    local most = TILT_MAX * (GRAVITY + wanted[3])
    if level > most then
        wanted[1], wanted[2] = wanted[1] * most / level, wanted[2] * most / level
    end
    return wanted
end

-- Angular accelerations about the body's axes that bring its z axis to `up` and its heading to the target's.
local function turning(x, y, z, up, dt)
    local _, spin = sim.getObjectVelocity(body + sim.handleflag_axis)
    local heading = axes_of(sim.getObjectQuaternion(target, -1))
    local yaw = math.atan(heading[2], heading[1]) - math.atan(x[2], x[1])
    yaw = (yaw + math.pi) % (2 * math.pi) - math.pi
    local errors = {-dot(up, y), dot(up, x), limited(yaw, 0.6)}
    local rates = {TILT_RATE, TILT_RATE, YAW_RATE}
    local wanted = {}
    for i, axis in ipairs {x, y, z} do
        local stiffness, damping = gains(rates[i], dt)
        wanted[i] = stiffness * errors[i] - damping * now(dot(spin, axis), turned[i], dt)
    end
    return wanted
end

function sysCall_init()
    body = sim.getObjectHandle('Quadricopter')
    base = sim.getObjectHandle('Quadricopter_base')
    target = sim.getObjectHandle('Quadricopter_target')
    for i = 1, 4 do
        respondables[i] = sim.getObjectHandle('Quadricopter_propeller_respondable' .. i)
        joints[i] = sim.getObjectHandle('Quadricopter_propeller_joint' .. i)
    end
    sim.setObjectParent(target, -1, true)
    last_place = sim.getObjectPosition(target, -1)
end

function sysCall_actuation()
    local dt = sim.getSimulationTimeStep()
    local x, y, z = axes_of(sim.getObjectQuaternion(body, -1))
    local wanted = wanted_acceleration(dt)
    local push = {wanted[1], wanted[2], wanted[3] + GRAVITY}
    local size = math.sqrt(dot(push, push))
    local up = {push[1] / size, push[2] / size, push[3] / size}
    local thrust = MASS * dot(push, z)
    local turn = turning(x, y, z, up, dt)
    local roll, pitch = INERTIA[1] * turn[1] / ARM / 4, INERTIA[2] * turn[2] / ARM / 4
    local yaw = limited(INERTIA[3] * turn[3] / DRAG / 4, YAW_SHARE)

    local total, torque = 0, {0, 0, 0}
    for i, rotor in ipairs(ROTORS) do
        local force = thrust / 4 + rotor[2] * roll - rotor[1] * pitch + rotor[3] * yaw
        force = math.max(0, math.min(ROTOR_MAX, force))
        local reaction = rotor[3] * DRAG * force
        sim.addForceAndTorque(respondables[i],
            {force * z[1], force * z[2], force * z[3]},
            {reaction * z[1], reaction * z[2], reaction * z[3]})
        sim.setJointPosition(joints[i], sim.getJointPosition(joints[i]) - rotor[3] * BLADE_TURN)
        total = total + force
        torque[1] = torque[1] + rotor[2] * ARM * force
        torque[2] = torque[2] - rotor[1] * ARM * force
        torque[3] = torque[3] + reaction
    end
    for i = 1, 3 do
        pushed[i] = total * z[i] / MASS - (i == 3 and GRAVITY or 0)
        turned[i] = torque[i] / INERTIA[i]
    end
end
