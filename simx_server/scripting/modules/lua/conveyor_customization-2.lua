-- The customization of a conveyor of CoppeliaSim 4, whose pads or rollers lie along a path, or whose belt is one shape.
--
-- CoppeliaSim moves the pads; here they stay in place, and their surfaces move along the path, which does the same to
-- what lies on them. A program sets the velocity or the position by the data block __ctrl__ ({vel = ...} or
-- {pos = ...}), and reads both from __state__; older ones read them from CONVMOV.

local conveyor = { vel = 0, pos = 0 }

local VELOCITY = { sim.shapefloatparam_init_velocity_x, sim.shapefloatparam_init_velocity_y,
    sim.shapefloatparam_init_velocity_z }

local target, goal, belts, driven

local function read(name)
    local data = sim.readCustomDataBlock(conveyor.model, name)
    return data and sim.unpackTable(data)
end

local function write(name, data) sim.writeCustomDataBlock(conveyor.model, name, sim.packTable(data)) end

local function report()
    write("__state__", { pos = conveyor.pos, vel = conveyor.vel })
    write("CONVMOV", { currentPos = conveyor.pos, vel = conveyor.vel })
end

-- The direction of the path nearest to a place, both in the conveyor's frame; without a path its x axis.
local function direction(place)
    local data = sim.readCustomDataBlock(conveyor.model, "PATH")
    if not data then return { 1, 0, 0 } end
    local points, places = sim.unpackDoubleTable(data), {}
    for i = 1, #points, 7 do
        for j = 0, 2 do places[#places + 1] = points[i + j] end
    end
    local lengths, total = sim.getPathLengths(places, 3)
    local at = sim.getClosestPosOnPath(places, lengths, place)
    local step = total / 200
    local from = sim.getPathInterpolatedConfig(places, lengths, math.max(0, at - step))
    local to = sim.getPathInterpolatedConfig(places, lengths, math.min(total, at + step))
    local way = { to[1] - from[1], to[2] - from[2], to[3] - from[3] }
    local length = math.sqrt(way[1] ^ 2 + way[2] ^ 2 + way[3] ^ 2)
    if length == 0 then return { 1, 0, 0 } end
    return { way[1] / length, way[2] / length, way[3] / length }
end

-- The static respondable shapes of the conveyor, with the directions of their surfaces in its frame.
local function find_belts()
    belts = {}
    for _, shape in ipairs(sim.getObjectsInTree(conveyor.model, sim.object_shape_type)) do
        local is_static = sim.getObjectInt32Param(shape, sim.shapeintparam_static) ~= 0
        if is_static and sim.getObjectInt32Param(shape, sim.shapeintparam_respondable) ~= 0 then
            belts[#belts + 1] = { shape = shape, way = direction(sim.getObjectPosition(shape, conveyor.model)) }
        end
    end
end

-- Give the surfaces a velocity; they keep it.
local function drive(velocity)
    if velocity == driven then return end
    driven = velocity
    local matrix = sim.getObjectMatrix(conveyor.model, -1)
    for _, belt in ipairs(belts) do
        sim.resetDynamicObject(belt.shape)
        for axis = 1, 3 do
            local row, way = 4 * (axis - 1), belt.way
            local along = matrix[row + 1] * way[1] + matrix[row + 2] * way[2] + matrix[row + 3] * way[3]
            sim.setObjectFloatParam(belt.shape, VELOCITY[axis], velocity * along)
        end
    end
end

-- What a program asks for: once, as the block is removed then.
local function obey()
    local asked = read("__ctrl__")
    if not asked then return end
    sim.writeCustomDataBlock(conveyor.model, "__ctrl__", "")
    if asked.vel then
        target, goal = asked.vel, nil
    elseif asked.pos then
        goal = asked.pos
    end
end

function conveyor.init(config)
    conveyor.config = config or {}
    local own = sim.getObject(".")
    conveyor.model = own
    target = conveyor.config.targetVel or conveyor.config.initVel or 0
    conveyor.vel, conveyor.pos, goal, driven = 0, conveyor.config.initPos or 0, nil, nil
    report()
end

conveyor.init2 = conveyor.init

function conveyor.beforeSimulation()
    driven = nil
    find_belts()
end

function conveyor.actuation()
    if not belts then find_belts() end
    obey()
    local step = sim.getSimulationTimeStep()
    local most = math.abs(conveyor.config.accel or math.huge) * step
    local wanted = target
    if goal then
        local fastest = math.abs(conveyor.config.maxVel or conveyor.config.targetVel or 0.1)
        wanted = math.max(-fastest, math.min(fastest, (goal - conveyor.pos) / step))
        most = math.huge
    end
    conveyor.vel = conveyor.vel + math.max(-most, math.min(most, wanted - conveyor.vel))
    conveyor.pos = conveyor.pos + conveyor.vel * step
    drive(conveyor.vel)
    report()
end

function conveyor.afterSimulation()
    conveyor.init(conveyor.config)
end

function sysCall_init() conveyor.init {} end
function sysCall_beforeSimulation() conveyor.beforeSimulation() end
function sysCall_actuation() conveyor.actuation() end
function sysCall_afterSimulation() conveyor.afterSimulation() end

_S = _S or {}
_S.conveyor, _S.conveyorSystem = conveyor, conveyor

return conveyor
