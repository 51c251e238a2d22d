# The gripper's child script in Python: the twin of scenes/models/rg2.lua.

FINGER_SPEED = 0.05  # m/s, of one pad relative to the other
FINGER_FORCE = 20  # N

motor = None
obeyed = None  # the last value of the signal that was acted on


def drive(velocity):
    sim.setJointForce(motor, FINGER_FORCE)
    sim.setJointTargetVelocity(motor, velocity)
    return [], [velocity], [], ""


def rg2Open(ints, floats, strings, buffer):
    return drive(FINGER_SPEED)


def rg2Close(ints, floats, strings, buffer):
    return drive(-FINGER_SPEED)


def sysCall_init():
    global motor
    motor = sim.getObjectHandle("RG2_openCloseJoint")
    drive(FINGER_SPEED)


def sysCall_actuation():
    global obeyed
    # Only a change counts: a signal that was left standing must not undo a later call.
    wanted = sim.getIntegerSignal("RG2_open")
    if wanted != obeyed:
        obeyed = wanted
        if wanted == 1:
            drive(FINGER_SPEED)
        elif wanted == 0:
            drive(-FINGER_SPEED)
