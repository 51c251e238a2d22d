-- What remote API programs ask of the object `remoteApiCommandServer`, as V-REP's two demo scenes with it offered:
-- texts, dummies and code (complexCommandTest), planning for an arm (pathPlanningTest), things to load and to make.
--
-- Every function gets and gives four tables: whole numbers, numbers, strings, and a string of bytes.
-- A robot is meant by the handle of its base. Its joints and tip are those of its inverse kinematics group (simx:ik:NAME),
-- else the joints above a dummy whose name ends in "ikTip" or "tip". A state is the values of these joints, a pose is
-- 12 numbers of a matrix. The demo's robot drew its paths; so does this.

local SPEED = 1.0        -- rad/s (m/s) of the fastest joint along a path
local ARRIVED = 0.01     -- rad (m): how near a driven joint must be to the path's end
local PATIENCE = 1.0     -- s that driven joints get for that
local SEARCH = 5         -- s at most for looking for states of a pose
local PLAN = 5           -- s at most for one path

local runs = {}          -- by robot: the path that is being followed
local collections = {}   -- by robot: all of it, for collision checks

local function need(count, list, what)
    if #list < count then error(what .. ": " .. count .. " needed, " .. #list .. " given", 0) end
end

local function part(list, first, count)
    return {unpack(list, first, first + count - 1)}
end

local function append(list, other)
    for _, value in ipairs(other) do list[#list + 1] = value end
end

-- Texts, dummies, code ---------------------------------------------------------------------------------------------

function displayText_function(ints, floats, strings, buffer)
    need(1, strings, "a text")
    sim.addStatusbarMessage(strings[1])
    sim.displayDialog("Message from the remote API client", strings[1], sim.dlgstyle_message, false)
    return {}, {}, {"message was displayed"}, ""
end

function displayMessage(ints, floats, strings, buffer)
    need(1, strings, "a text")
    sim.addStatusbarMessage((strings[1]:gsub("&&n", "\n")))
    return {}, {}, {}, ""
end

-- Position, or position and quaternion; in the frame of ints[1] if that is given and not -1.
function createDummy_function(ints, floats, strings, buffer)
    need(1, strings, "a name")
    need(3, floats, "coordinates of a position")
    local relativeTo = ints[1] or -1
    local dummy = sim.createDummy(0.05)
    sim.setObjectName(dummy, strings[1])
    sim.setObjectPosition(dummy, relativeTo, part(floats, 1, 3))
    if #floats >= 7 then sim.setObjectQuaternion(dummy, relativeTo, part(floats, 4, 4)) end
    return {dummy}, {}, {}, ""
end

function executeCode_function(ints, floats, strings, buffer)
    need(1, strings, "code")
    if not simx.isCodeAllowed() then
        error("the server runs no code that clients send; whoever may start it can allow that with --allow-code", 0)
    end
    local chunk, problem = load(strings[1], "=code of the client")
    if not chunk then error(problem, 0) end
    local result = chunk()
    return {}, {}, {result == nil and "" or tostring(result)}, ""
end

-- Things -----------------------------------------------------------------------------------------------------------

local function place(handle, floats, first)
    if #floats >= first + 2 then sim.setObjectPosition(handle, -1, part(floats, first, 3)) end
    if #floats >= first + 5 then sim.setObjectOrientation(handle, -1, part(floats, first + 3, 3)) end
end

local function letFall(shape, mass)
    sim.setObjectInt32Param(shape, sim.shapeintparam_static, 0)
    sim.setObjectInt32Param(shape, sim.shapeintparam_respondable, 1)
    if mass then sim.setShapeMass(shape, mass) end
end

-- A mesh file of the workspace: position, Euler angles and colour; strings: file, name. It falls.
function importShape(ints, floats, strings, buffer)
    need(1, strings, "a mesh file")
    local shape = sim.importShape(0, strings[1], 0, 0, 1)
    if strings[2] then sim.setObjectName(shape, strings[2]) end
    if #floats >= 9 then sim.setShapeColor(shape, nil, sim.colorcomponent_ambient_diffuse, part(floats, 7, 3)) end
    place(shape, floats, 1)
    letFall(shape)
    return {shape}, {}, {}, ""
end

-- A shape by its name: position and Euler angles.
function moveShape(ints, floats, strings, buffer)
    need(1, strings, "a name")
    local shape = sim.getObjectHandle(strings[1])
    place(shape, floats, 1)
    return {shape}, {}, {}, ""
end

-- 0 cuboid, 1 sphere, 2 cylinder, 3 cone; three sizes, position, Euler angles, mass; a name. It falls.
function spawnShape(ints, floats, strings, buffer)
    need(6, floats, "sizes and coordinates")
    local shape = sim.createPureShape(ints[1] or 0, 8, part(floats, 1, 3), floats[10] or 0.1)
    if strings[1] then sim.setObjectName(shape, strings[1]) end
    place(shape, floats, 4)
    return {shape}, {}, {}, ""
end

-- A model file: x, y, z and turn about the vertical, added to where the file has it.
function loadRobot(ints, floats, strings, buffer)
    need(1, strings, "a model file")
    local base = sim.loadModel(strings[1])
    local at, turned = sim.getObjectPosition(base, -1), sim.getObjectOrientation(base, -1)
    sim.setObjectPosition(base, -1, {at[1] + (floats[1] or 0), at[2] + (floats[2] or 0), at[3] + (floats[3] or 0)})
    sim.setObjectOrientation(base, -1, {turned[1], turned[2], turned[3] + (floats[4] or 0)})
    return {base}, {}, {}, ""
end

-- An arm -----------------------------------------------------------------------------------------------------------

function getObjectPose(ints, floats, strings, buffer)
    need(1, ints, "the handle of an object")
    return {}, sim.getObjectMatrix(ints[1], -1), {}, ""
end

local function stateOf(joints)
    local state = {}
    for i, joint in ipairs(joints) do state[i] = sim.getJointPosition(joint) end
    return state
end

function getRobotState(ints, floats, strings, buffer)
    need(1, ints, "the handle of a robot")
    local _, joints = simx.getArm(ints[1])
    return {}, stateOf(joints), {}, ""
end

local function distance(a, b)
    local sum = 0
    for i = 1, #a do sum = sum + (a[i] - b[i]) ^ 2 end
    return sum
end

-- A planning task in the arm's joints; what must not meet is the robot and all else.
local function newTask(robot, joints, checksCollisions)
    local task, spaces = simOMPL.createTask("path"), {}
    for i, joint in ipairs(joints) do
        local cyclic, interval = sim.getJointInterval(joint)
        local low, high = -math.pi, math.pi
        if not cyclic then low, high = math.max(interval[1], -2 * math.pi), math.min(interval[1] + interval[2], 2 * math.pi) end
        spaces[i] = simOMPL.createStateSpace("joint" .. i, simOMPL.StateSpaceType.joint_position, joint, {low}, {high}, 1)
    end
    simOMPL.setStateSpace(task, spaces)
    if checksCollisions then
        if not collections[robot] then
            collections[robot] = sim.createCollection(0)
            sim.addItemToCollection(collections[robot], sim.handle_tree, robot, 0)
        end
        simOMPL.setCollisionPairs(task, {collections[robot], sim.handle_all})
    end
    local function forget()
        simOMPL.destroyTask(task)
        for _, space in ipairs(spaces) do simOMPL.destroyStateSpace(space) end
    end
    return task, forget
end

-- The same arm in a world of its own, with a target that is nothing in the scene.
local function newSolver(robot, tip)
    local environment = simIK.createEnvironment()
    local group = simIK.createGroup(environment)
    local target = simIK.createDummy(environment, "target")
    simIK.setGroupCalculation(environment, group, simIK.method_damped_least_squares, 0.05, 100)
    simIK.addElementFromScene(environment, group, robot, tip, target, simIK.constraint_pose)
    return environment, group, target
end

local function setState(environment, joints, state)
    for i, joint in ipairs(joints) do simIK.setJointPosition(environment, joint, state[i]) end
end

-- States from `state` along a straight line of the tip to a pose; nil when that is not possible.
local function straight(solver, joints, tip, state, pose, count, task)
    local environment, group, target = unpack(solver)
    setState(environment, joints, state)
    simIK.setObjectMatrix(environment, target, -1, pose)
    local function isFree(values) return simOMPL.isStateValid(task, values) end
    return simIK.generatePath(environment, group, joints, tip, count, isFree)
end

local function plan(task, start, goal, searches, count)
    simOMPL.setStartState(task, start)
    simOMPL.setGoalState(task, goal)
    for _ = 1, math.max(1, searches) do
        local found, path = simOMPL.compute(task, PLAN, -1, count)
        if found then return path end
    end
    return nil
end

-- ints: robot, collision checking, states of the straight part and of the planned one, most states of the pose, trials,
-- searches; floats: state, pose, way in the pose's own axes on which it is approached straight.
-- Gives how many states are planned and straight, and these; nothing when there is no path.
function findPath_goalIsPose(ints, floats, strings, buffer)
    need(1, ints, "the handle of a robot")
    local robot = ints[1]
    local tip, joints = simx.getArm(robot)
    local n = #joints
    need(n + 12, floats, "numbers of a state and a pose")
    local start, pose = part(floats, 1, n), part(floats, n + 1, 12)
    local shift = #floats >= n + 15 and part(floats, n + 13, 3) or {0, 0, 0}
    local hasApproach = shift[1] ~= 0 or shift[2] ~= 0 or shift[3] ~= 0
    local before = part(pose, 1, 12)
    for row = 0, 2 do
        local along = pose[4 * row + 1] * shift[1] + pose[4 * row + 2] * shift[2] + pose[4 * row + 3] * shift[3]
        before[4 * row + 4] = pose[4 * row + 4] - along
    end

    local task, forget = newTask(robot, joints, ints[2] ~= 0)
    local solver = {newSolver(robot, tip)}
    local environment, group, target = unpack(solver)
    setState(environment, joints, start)
    simIK.setObjectMatrix(environment, target, -1, before)
    local options = {maxTime = SEARCH, findMultiple = true, cb = function(state) return simOMPL.isStateValid(task, state) end}
    local states = simIK.findConfigs(environment, group, joints, options)
    table.sort(states, function(a, b) return distance(a, start) < distance(b, start) end)

    local first, second
    for i = 1, math.min(#states, math.max(1, ints[5] or 10)) do
        second = hasApproach and straight(solver, joints, tip, states[i], pose, math.max(2, ints[3] or 100), task) or nil
        if second or not hasApproach then
            first = plan(task, start, states[i], ints[7] or 1, ints[4] or 0)
        end
        if first then break end
    end
    forget()
    simIK.eraseEnvironment(environment)
    if not first then return {0, 0}, {}, {}, "" end
    local counts = {#first // n, second and #second // n or 0}
    append(first, second or {})
    return counts, first, {}, ""
end

-- ints: robot, collision checking, states of the path, searches; floats: two states.
function findPath_goalIsState(ints, floats, strings, buffer)
    need(1, ints, "the handle of a robot")
    local _, joints = simx.getArm(ints[1])
    local n = #joints
    need(2 * n, floats, "numbers of two states")
    local task, forget = newTask(ints[1], joints, ints[2] ~= 0)
    local path = plan(task, part(floats, 1, n), part(floats, n + 1, n), ints[4] or 1, ints[3] or 0)
    forget()
    return {path and #path // n or 0}, path or {}, {}, ""
end

-- ints: robot, collision checking, states of each line; floats: state, and poses that are visited on straight lines.
function findIkPath(ints, floats, strings, buffer)
    need(1, ints, "the handle of a robot")
    local robot = ints[1]
    local tip, joints = simx.getArm(robot)
    local n = #joints
    need(n + 12, floats, "numbers of a state and a pose")
    local task, forget = newTask(robot, joints, ints[2] ~= 0)
    local solver = {newSolver(robot, tip)}
    local state, path = part(floats, 1, n), {}
    for first = n + 1, #floats - 11, 12 do
        local piece = straight(solver, joints, tip, state, part(floats, first, 12), math.max(2, ints[3] or 100), task)
        if not piece then
            path = {}
            break
        end
        append(path, piece)
        state = part(piece, #piece - n + 1, n)
    end
    forget()
    simIK.eraseEnvironment(solver[1])
    return {#path // n}, path, {}, ""
end

-- ints: robot, and a colour of 0..255; gives the handle for removeLine.
function visualizePath(ints, floats, strings, buffer)
    need(1, ints, "the handle of a robot")
    local tip, joints = simx.getArm(ints[1])
    local n = #joints
    local color = {(ints[2] or 255) / 255, (ints[3] or 0) / 255, (ints[4] or 255) / 255}
    local line = sim.addDrawingObject(sim.drawing_linestrip, 2, 0, -1, 99999, color)
    local environment, group = newSolver(ints[1], tip)
    for first = 1, #floats - n + 1, n do
        setState(environment, joints, part(floats, first, n))
        sim.addDrawingObjectItem(line, part(simIK.getObjectPose(environment, tip), 1, 3))
    end
    simIK.eraseEnvironment(environment)
    return {line}, {}, {}, ""
end

function removeLine(ints, floats, strings, buffer)
    need(1, ints, "the handle of a line")
    sim.removeDrawingObject(ints[1])
    return {}, {}, {}, ""
end

local function move(joints, state)
    for i, joint in ipairs(joints) do
        if sim.getJointMode(joint) == sim.jointmode_force then
            sim.setJointTargetPosition(joint, state[i])
        else
            sim.setJointPosition(joint, state[i])
        end
    end
end

function setRobotState(ints, floats, strings, buffer)
    need(1, ints, "the handle of a robot")
    local _, joints = simx.getArm(ints[1])
    need(#joints, floats, "numbers of a state")
    for i, joint in ipairs(joints) do sim.setJointPosition(joint, floats[i]) end
    move(joints, floats)
    return {}, {}, {}, ""
end

function runThroughPath(ints, floats, strings, buffer)
    need(1, ints, "the handle of a robot")
    local _, joints = simx.getArm(ints[1])
    if #floats % #joints ~= 0 then error("a path has states of " .. #joints .. " numbers", 0) end
    if #floats > 0 then runs[ints[1]] = {joints = joints, path = floats, index = 1, waited = 0} end
    return {}, {}, {}, ""
end

function isRunningThroughPath(ints, floats, strings, buffer)
    need(1, ints, "the handle of a robot")
    return {runs[ints[1]] and 1 or 0}, {}, {}, ""
end

-- Go along the path as far as the time of one pass reaches; true at its end.
local function advance(run)
    local n, left = #run.joints, SPEED * sim.getSimulationTimeStep()
    local count = #run.path // n
    run.at = run.at or part(run.path, 1, n)
    while run.index < count and left > 0 do
        local goal, longest = part(run.path, run.index * n + 1, n), 0
        for i = 1, n do longest = math.max(longest, math.abs(goal[i] - run.at[i])) end
        local share = longest > left and left / longest or 1
        for i = 1, n do run.at[i] = run.at[i] + share * (goal[i] - run.at[i]) end
        left = left - longest
        if share == 1 then run.index = run.index + 1 end
    end
    move(run.joints, run.at)
    if run.index < count then return false end
    run.waited = run.waited + sim.getSimulationTimeStep()
    for i, joint in ipairs(run.joints) do
        local off = math.abs(sim.getJointPosition(joint) - run.at[i])
        if math.min(off, math.abs(off - 2 * math.pi)) > ARRIVED then return run.waited > PATIENCE end
    end
    return true
end

function sysCall_actuation()
    for robot, run in pairs(runs) do
        if not sim.isHandle(robot) or advance(run) then runs[robot] = nil end
    end
end
