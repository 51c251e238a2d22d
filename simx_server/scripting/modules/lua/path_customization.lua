-- The customization of a path of CoppeliaSim 4: a dummy, with dummies below it as control points.
--
-- The path's points are data of the dummy: block PATH, poses at equal lengths. Whenever a control point was moved, they
-- are computed again. The script of a path may define path.shaping, which makes a shape along the path, and
-- path.refreshTrigger, which is told of each change.

local path = { paths = {} }

local INFO, CONTROL = "ABC_PATH_INFO", "ABC_PATHCTRLPT"
local CLOSED, TURNED = 2, 16
local POSE, TYPES = 7, { 0, 0, 0, 2, 2, 2, 2 }

-- The axis along the path, and the one that points upwards, of each orientation mode.
local AXES = { [0] = { 1, 2 }, { 1, 3 }, { 2, 1 }, { 2, 3 }, { 3, 1 }, { 3, 2 } }

local known, drawing

-- The dummy that this script belongs to: the script's object, or in CoppeliaSim 4.7 and later the one above it.
local function model_of_script()
    local own = sim.getObject(".")
    if not sim.readCustomDataBlock(own, INFO) then
        local above = sim.getObjectParent(own)
        if above ~= -1 and sim.readCustomDataBlock(above, INFO) then return above end
    end
    return own
end

function path.readInfo()
    local data = sim.readCustomDataBlock(path.model, INFO)
    local info = data and sim.unpackTable(data) or {}
    info.bitCoded = info.bitCoded or 0
    info.pointCnt = info.pointCnt or 100
    info.smoothing = info.smoothing or 1
    info.autoOrientation = info.autoOrientation or 0
    info.upVector = info.upVector or { 0, 0, 1 }
    info.line = info.line or {}
    return info
end

function path.writeInfo(info)
    sim.writeCustomDataBlock(path.model, INFO, sim.packTable(info))
end

-- Handles of the control points in their order.
function path.getCtrlPts()
    local found = {}
    for _, handle in ipairs(sim.getObjectsInTree(path.model, sim.object_dummy_type, 1 + 2)) do
        local data = sim.readCustomDataBlock(handle, CONTROL)
        if data then found[#found + 1] = { handle = handle, index = sim.unpackTable(data).index or #found + 1 } end
    end
    table.sort(found, function(a, b) return a.index < b.index end)
    local handles = {}
    for i, each in ipairs(found) do handles[i] = each.handle end
    return handles
end

local function cross(a, b)
    return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
end

local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end

local function unit(vector)
    local length = math.sqrt(dot(vector, vector))
    if length > 1e-6 then return { vector[1] / length, vector[2] / length, vector[3] / length } end
end

local function place(points, index) return { table.unpack(points, index * POSE + 1, index * POSE + 3) } end

-- Turn the points along the way.
local function orient(points, info, is_closed)
    local last = #points // POSE - 1
    local along, upwards = table.unpack(AXES[info.autoOrientation] or AXES[0])
    local turn = { 0, 0, 0, 1 }
    for index = 0, last do
        local before, after = index - 1, index + 1
        if before < 0 then before = is_closed and last - 1 or 0 end
        if after > last then after = is_closed and 1 or last end
        local from, to = place(points, before), place(points, after)
        local forward = unit { to[1] - from[1], to[2] - from[2], to[3] - from[3] }
        local up = info.upVector
        local rise = forward and dot(forward, up)
        local across = forward
            and unit { up[1] - rise * forward[1], up[2] - rise * forward[2], up[3] - rise * forward[3] }
        if across then
            local axes = { [along] = forward, [upwards] = across }
            local third = 6 - along - upwards
            axes[third] = cross(axes[third % 3 + 1], axes[(third + 1) % 3 + 1])
            local x, y, z = axes[1], axes[2], axes[3]
            local pose = sim.matrixToPose { x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, x[3], y[3], z[3], 0 }
            turn = { table.unpack(pose, 4, 7) }
        end
        for i = 1, 4 do points[index * POSE + 3 + i] = turn[i] end
    end
end

-- The points of a path through control points, poses in one list.
local function points_of(control, info, is_closed)
    local numbers = { table.unpack(control) }
    if is_closed then
        for i = 1, POSE do numbers[#numbers + 1] = control[i] end
    end
    local lengths = sim.getPathLengths(numbers, POSE)
    if info.smoothing > 0 then
        local method = { type = "quadraticBezier", strength = math.min(info.smoothing, 1), forceOpen = not is_closed }
        local count = 2 * math.max(info.pointCnt, 20 * (#control // POSE))
        numbers = sim.resamplePath(numbers, lengths, count, method, TYPES)
        lengths = sim.getPathLengths(numbers, POSE)
    end
    local points = sim.resamplePath(numbers, lengths, info.pointCnt, { type = "linear", forceOpen = true }, TYPES)
    if info.bitCoded & TURNED ~= 0 then orient(points, info, is_closed) end
    return points
end

local function draw(points, info)
    if drawing then sim.removeDrawingObject(drawing) end
    local color = info.line.color or { 0, 0.96, 0.66 }
    local flags = sim.drawing_lines + sim.drawing_local
    drawing = sim.addDrawingObject(flags, info.line.thickness or 3, 0, path.model, 0, color)
    for index = 0, #points // POSE - 2 do
        local from, to = place(points, index), place(points, index + 1)
        sim.addDrawingObjectItem(drawing, { from[1], from[2], from[3], to[1], to[2], to[3] })
    end
end

-- Compute the points again if a control point was moved, or settings changed.
function path.refresh(always)
    local handles = path.getCtrlPts()
    if #handles < 2 then return end
    local control = {}
    for _, handle in ipairs(handles) do
        for _, number in ipairs(sim.getObjectPose(handle, path.model)) do control[#control + 1] = number end
    end
    local mark = sim.packDoubleTable(control) .. (sim.readCustomDataBlock(path.model, INFO) or "")
    if mark == known and not always then return end
    local info, is_first = path.readInfo(), known == nil
    local is_closed = info.bitCoded & CLOSED ~= 0
    known = mark
    local stored = sim.readCustomDataBlock(path.model, "PATHCTRLPTS")
    local points = sim.readCustomDataBlock(path.model, "PATH")
    if is_first and not always and stored and points and path.isNear(sim.unpackDoubleTable(stored), control) then
        points = sim.unpackDoubleTable(points)
    else
        points = points_of(control, info, is_closed)
        sim.writeCustomDataBlock(path.model, "PATHCTRLPTS", sim.packDoubleTable(control))
        sim.writeCustomDataBlock(path.model, "PATH", sim.packDoubleTable(points))
        if path.refreshTrigger then path.refreshTrigger(handles, points, info) end
    end
    path.paths[1], path.paths[2] = control, points
    draw(points, info)
end

-- Whether two lists have the same numbers, but for rounding.
function path.isNear(first, second)
    if #first ~= #second then return false end
    for i, number in ipairs(first) do
        if math.abs(number - second[i]) > 1e-5 then return false end
    end
    return true
end

function path.init()
    path.model = model_of_script()
    path.refresh()
end

function path.nonSimulation() path.refresh() end
function path.beforeSimulation() end
function path.sensing() path.refresh() end
function path.cleanup() end

-- The end of a run moves control points back; the next nonSimulation draws again.
function path.afterSimulation() known = nil end

-- A script that has call-backs of its own calls those of the path from there.
function sysCall_init() path.init() end
function sysCall_nonSimulation() path.nonSimulation() end
function sysCall_beforeSimulation() path.beforeSimulation() end
function sysCall_sensing() path.sensing() end
function sysCall_afterSimulation() path.afterSimulation() end
function sysCall_cleanup() path.cleanup() end

return path
