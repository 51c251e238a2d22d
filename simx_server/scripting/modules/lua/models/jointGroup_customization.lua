-- The customization of a joint group: a dummy whose references are joints that move together.

local group, motion

function getJoints() return sim.getReferencedHandles(group) end

function isDynamicallyEnabled()
    for _, joint in ipairs(getJoints()) do
        if not sim.isDynamicallyEnabled(joint) then return false end
    end
    return true
end

local function values(read)
    local found = {}
    for i, joint in ipairs(getJoints()) do found[i] = read(joint) end
    return found
end

local function give(write, config)
    for i, joint in ipairs(getJoints()) do write(joint, config[i]) end
end

function getConfig() return values(sim.getJointPosition) end
function getTargetConfig() return values(sim.getJointTargetPosition) end
function setConfig(config) give(sim.setJointPosition, config) end
function setTargetConfig(config) give(sim.setJointTargetPosition, config) end

-- Move all joints to `targetPos` of the options, with the limits maxVel, maxAccel and maxJerk of each joint.
function moveToConfigInit(options)
    moveToConfigCleanup()
    local count = #getJoints()
    if type(options) ~= "table" or type(options.targetPos) ~= "table" or #options.targetPos ~= count then
        error("missing or invalid 'targetPos' field", 2)
    end
    local function each(name, value) return options[name] or table.rep(value, count) end
    local state = table.add(getConfig(), each("vel", 0), each("accel", 0))
    local limits = table.add(each("maxVel", math.rad(1440)), each("maxAccel", math.rad(720)),
        each("maxJerk", math.rad(360)))
    motion = { handle = sim.ruckigPos(count, 0.0001, options.flags or -1, state, limits, table.rep(1, count),
        table.add(options.targetPos, each("targetVel", 0))) }
end

function moveToConfig(options)
    moveToConfigInit(options)
    motion.runs = true
end

function moveToConfigCleanup()
    if motion then sim.ruckigRemove(motion.handle) end
    motion = nil
end

-- One step of the motion; at its end the positions, velocities and accelerations are not returned.
function moveToConfigStep()
    if not motion then return nil end
    local result, state = sim.ruckigStep(motion.handle, sim.getSimulationTimeStep())
    local count = #getJoints()
    local place = table.slice(state, 1, count)
    if isDynamicallyEnabled() then setTargetConfig(place) else setConfig(place) end
    if result ~= 0 then
        moveToConfigCleanup()
        return nil
    end
    return { pos = place, vel = table.slice(state, count + 1, 2 * count), accel = table.slice(state, 2 * count + 1) }
end

function isMoveToConfigRunning() return motion ~= nil and motion.runs == true end

function sysCall_init() group = sim.getObject(".") end

function sysCall_actuation()
    if isMoveToConfigRunning() then moveToConfigStep() end
end

function sysCall_cleanup() moveToConfigCleanup() end
