-- Motions of CoppeliaSim's API 2, over the functions of API 1: RuckigPosition, RuckigVelocity, MoveToConfig,
-- MoveToPose with step() and data(), and TimeOptimalTrajectory.

local api_1 = require("sim")
local eigen = require("simEigen")

local Motion = {}

local function numbers(value, count, name)
    if value == nil and count then
        local zeros = {}
        for i = 1, count do zeros[i] = 0.0 end
        return zeros
    end
    if eigen.ismatrix(value) or eigen.ispose(value) then value = value:data() end
    assert(type(value) == "table", "the field '" .. name .. "' is a vector")
    assert(not count or #value == count, "the field '" .. name .. "' has another length than 'pos'")
    return value
end

local function joined(...)
    local whole = {}
    for _, part in ipairs { ... } do table.move(part, 1, #part, #whole + 1, whole) end
    return whole
end

local function class(construct)
    local kind = {}
    kind.__index = kind
    return setmetatable(kind, { __call = function(_, params)
        assert(params == nil or type(params) == "table", "a motion is made of a map")
        return setmetatable(construct(params or {}), kind)
    end })
end

-- Profiles.

local function state_of(params)
    local pos = numbers(params.pos, nil, "pos")
    local count = #pos
    return count, pos, numbers(params.vel, count, "vel"), numbers(params.accel, count, "accel")
end

local function selected(params, count)
    local chosen = {}
    for i = 1, count do
        local value = params.selection and params.selection[i]
        chosen[i] = value ~= false and value ~= 0
    end
    return chosen
end

local function profile(params, count, pos, vel, accel, handle)
    return { _handle = handle, _count = count, _step = params.timeStep or 0.0, _sync = 0.0,
        _state = joined(pos, vel, accel) }
end

local RuckigPosition = class(function(params)
    local count, pos, vel, accel = state_of(params)
    local limits = joined(numbers(params.maxVel, count, "maxVel"), numbers(params.maxAccel, count, "maxAccel"),
        numbers(params.maxJerk, count, "maxJerk"))
    local goal = joined(numbers(params.targetPos, count, "targetPos"), numbers(params.targetVel, count, "targetVel"))
    return profile(params, count, pos, vel, accel, api_1.ruckigPos(count, params.baseCycleTime or 0.0001,
        params.flags or -1, joined(pos, vel, accel), limits, selected(params, count), goal))
end)

local RuckigVelocity = class(function(params)
    local count, pos, vel, accel = state_of(params)
    local limits = joined(numbers(params.maxAccel, count, "maxAccel"), numbers(params.maxJerk, count, "maxJerk"))
    return profile(params, count, pos, vel, accel, api_1.ruckigVel(count, params.baseCycleTime or 0.0001,
        params.flags or -1, joined(pos, vel, accel), limits, selected(params, count),
        numbers(params.targetVel, count, "targetVel")))
end)

for _, kind in ipairs { RuckigPosition, RuckigVelocity } do
    function kind:step()
        local seconds = self._step > 0 and self._step or api_1.getSimulationTimeStep()
        local result, state, left = api_1.ruckigStep(self._handle, seconds)
        self._state, self._sync = state, left
        return result
    end

    function kind:data()
        local count, found = self._count, {}
        for place, name in ipairs { "pos", "vel", "accel" } do
            found[name] = table.move(self._state, (place - 1) * count + 1, place * count, 1, {})
        end
        found.syncTime, found.handle = self._sync, self._handle
        return found
    end

    function kind:remove() api_1.ruckigRemove(self._handle) end
end

-- Moves of joints and objects.

local function lowered(params)
    local copy = {}
    for name, value in next, params do
        if eigen.ismatrix(value) or eigen.ispose(value) then
            copy[name] = value:data()
        elseif name == "joints" then
            copy[name] = {}
            for i, joint in ipairs(value) do copy[name][i] = type(joint) == "table" and joint.handle or joint end
        elseif type(value) == "table" and rawget(value, "__handle") then
            copy[name] = value.handle
        else
            copy[name] = value
        end
    end
    return copy
end

local function mover(name)
    local kind = class(function(params) return { _data = api_1[name .. "_init"](lowered(params)) } end)

    function kind:step()
        local result, data = api_1[name .. "_step"](self._data)
        self._data = data
        return result
    end

    function kind:run()
        local result = self:step()
        while result == 0 do
            api_1.step()
            result = self:step()
        end
        return result
    end

    function kind:data() return self._data end
    function kind:remove() api_1[name .. "_cleanup"](self._data) end
    return kind
end

-- Trajectories.

local TimeOptimalTrajectory = class(function() return {} end)

function TimeOptimalTrajectory.generate(_, params)
    local path = params.path
    local rows = eigen.ismatrix(path) and path:rows() or #path
    local points = eigen.ismatrix(path) and path:t():data() or joined(table.unpack(path))
    local function limits(name)
        local most, pairs_of = numbers(params["max" .. name], rows, "max" .. name), {}
        local least = params["min" .. name] and numbers(params["min" .. name], rows, "min" .. name)
        for i = 1, rows do pairs_of[#pairs_of + 1], pairs_of[#pairs_of + 2] = least and least[i] or -most[i], most[i] end
        return pairs_of
    end
    local found, times = api_1.generateTimeOptimalTrajectory(points, numbers(params.pathLengths, nil, "pathLengths"),
        limits("Vel"), limits("Accel"),
        params.samples or 1000, params.boundaryCondition or "not-a-knot")
    return eigen.Matrix(#found // rows, rows, found):t(), eigen.Vector(times)
end

function TimeOptimalTrajectory.remove() end

Motion.RuckigPosition, Motion.RuckigVelocity = RuckigPosition, RuckigVelocity
Motion.MoveToConfig, Motion.MoveToPose = mover("moveToConfig"), mover("moveToPose")
Motion.TimeOptimalTrajectory = TimeOptimalTrajectory
return Motion
