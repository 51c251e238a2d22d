-- Commands come as signals, one letter each; answers go back as signals of every type.
local motor, base
local served = 0

local commands = {
    o = function() sim.setJointTargetVelocity(motor, 0.05) end,
    c = function() sim.setJointTargetVelocity(motor, -0.05) end,
    p = function()
        local data = sim.packFloatTable({sim.getJointPosition(motor), served, -1.5})
        sim.setStringSignal('packed', data)
    end,
    q = function()
        local values = sim.unpackFloatTable(sim.getStringSignal('packed'))
        sim.setFloatSignal('unpacked', values[1] + values[2] + values[3])
    end,
    m = function()
        local p = sim.getObjectPosition(base, -1)
        sim.setObjectPosition(base, -1, {p[1] + 0.01, p[2], p[3]})
    end,
}

function sysCall_init()
    motor = sim.getObjectHandle('RG2_openCloseJoint')
    base = sim.getObjectHandle('plain')
    sim.setIntegerSignal('served', served)
end

function sysCall_actuation()
    local text = sim.getStringSignal('commands')
    if text == nil then return end
    sim.clearStringSignal('commands')
    for i = 1, #text do
        local command = commands[text:sub(i, i)]
        if command then
            command()
            served = served + 1
        else
            sim.addStatusbarMessage('unknown: ' .. text:sub(i, i))
        end
    end
    sim.setIntegerSignal('served', served)
end

function answer(ints, floats, strings, buffer)
    local sum = 0
    for i = 1, #ints do sum = sum + ints[i] end
    for i = 1, #floats do floats[i] = floats[i] / 2 end
    strings[#strings + 1] = 'more'
    return {sum, served}, floats, strings, buffer .. '\255\0x'
end
