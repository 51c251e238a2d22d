-- The gripper's child script. Clients open and close the RG2 in either of two ways:
--   * call rg2Open or rg2Close on object RG2: results {}, {finger velocity in m/s}, {}, ''
--   * set the integer signal RG2_open: 1 opens, 0 closes
-- The finger motor is velocity controlled: it keeps pushing with its full force when it meets something.
-- The gripper opens when the simulation starts.

local FINGER_SPEED = 0.05   -- m/s, of one pad relative to the other
local FINGER_FORCE = 20     -- N

local motor
local obeyed                -- the last value of the signal that was acted on

local function drive(velocity)
    sim.setJointForce(motor, FINGER_FORCE)
    sim.setJointTargetVelocity(motor, velocity)
    return {}, {velocity}, {}, ''
end

function rg2Open(ints, floats, strings, buffer)
    return drive(FINGER_SPEED)
end

function rg2Close(ints, floats, strings, buffer)
    return drive(-FINGER_SPEED)
end

function sysCall_init()
    motor = sim.getObjectHandle('RG2_openCloseJoint')
    drive(FINGER_SPEED)
end

function sysCall_actuation()
    -- Only a change counts: a signal that was left standing must not undo a later call.
    local wanted = sim.getIntegerSignal('RG2_open')
    if wanted ~= obeyed then
        obeyed = wanted
        if wanted == 1 then
            drive(FINGER_SPEED)
        elseif wanted == 0 then
            drive(-FINGER_SPEED)
        end
    end
end
