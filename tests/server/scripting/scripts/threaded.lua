-- A thread that moves the finger by waits of every kind while call-backs run.
local motor = sim.getObjectHandle('RG2_openCloseJoint')
local count = 0

local function note(text, number)
    sim.addStatusbarMessage(string.format('%s %.9g %.9g %d', text, sim.getSimulationTime(), number or 0, count))
end

function sysCall_thread()
    sim.setThreadAutomaticSwitch(false)
    note('begun')
    sim.setJointTargetVelocity(motor, 0.05)
    local late = sim.wait(0.23)
    note('waited', late)
    for i = 1, 3 do
        sim.step()
        note('step', i)
    end
    sim.setJointTargetVelocity(motor, -0.05)
    sim.switchThread()
    sim.setIntegerSignal('ready', 7)
    local value = sim.waitForSignal('go')
    note('go', value)
    local well = pcall(sim.wait, -1)
    note('refused', well and 1 or 0)
    while sim.getJointPosition(motor) > 0 do
        sim.switchThread()
    end
    note('closed', sim.getJointPosition(motor))
end

function sysCall_actuation()
    count = count + 1
    if count == 14 then
        sim.setFloatSignal('go', 2.5)
    end
end

function sysCall_cleanup()
    note('cleanup')
end
