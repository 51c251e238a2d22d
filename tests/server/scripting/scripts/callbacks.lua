-- Every call-back, with many calls in each: matrices, several results, refusals, tables.
local motor, base, made
local calls = 0

local function note(text, values)
    local words = {text, tostring(calls)}
    for _, value in ipairs(values or {}) do words[#words + 1] = string.format('%.9g', value) end
    sim.addStatusbarMessage(table.concat(words, ' '))
end

local function look(text)
    calls = calls + 1
    local values = {sim.getSimulationTime(), sim.getJointPosition(motor)}
    for _, x in ipairs(sim.getObjectPosition(base, -1)) do values[#values + 1] = x end
    for _, x in ipairs(sim.getObjectMatrix(base, -1)) do values[#values + 1] = x end
    local linear, angular = sim.getObjectVelocity(base)
    for i = 1, 3 do
        values[#values + 1] = linear[i]
        values[#values + 1] = angular[i]
    end
    note(text, values)
end

function sysCall_init()
    motor = sim.getObjectHandle('RG2_openCloseJoint')
    base = sim.getObjectHandle('plain')
    look('init')
    sim.writeCustomDataBlock(base, 'block', sim.packInt32Table({1, 2, 3}))
    sim.setJointTargetVelocity(motor, 0.02)
end

function sysCall_actuation()
    look('actuation')
    for i = 1, 5 do
        local e = sim.getObjectOrientation(base, -1)
        sim.setObjectOrientation(base, -1, {e[1], e[2], e[3] + 0.01 * i})
    end
    local numbers = sim.unpackInt32Table(sim.readCustomDataBlock(base, 'block'))
    numbers[1] = numbers[1] + numbers[3]
    sim.writeCustomDataBlock(base, 'block', sim.packInt32Table(numbers))
    note('numbers', numbers)
end

function sysCall_sensing()
    look('sensing')
    local ok, problem = pcall(sim.getObjectPosition, 123456, -1)
    note(ok and 'found' or 'not found')
    note('kind', {sim.getObjectType(base), sim.getObjectParent(base), sim.handle_self})
    note(sim.getStringSignal('nothing') == nil and 'nil' or 'something')
end

function sysCall_suspend() note('suspend') end
function sysCall_resume() note('resume') end

function sysCall_cleanup()
    look('cleanup')
end
