# Every call-back, with many calls in each: matrices, several results, refusals, tables.
calls = 0


def note(text, values=()):
    words = [text, str(calls), *("%.9g" % value for value in values)]
    sim.addStatusbarMessage(" ".join(words))


def look(text):
    global calls
    calls += 1
    values = [sim.getSimulationTime(), sim.getJointPosition(motor)]
    values += sim.getObjectPosition(base, -1) + sim.getObjectMatrix(base, -1)
    linear, angular = sim.getObjectVelocity(base)
    for pair in zip(linear, angular, strict=True):
        values += pair
    note(text, values)


def sysCall_init():
    global motor, base
    motor = sim.getObjectHandle("RG2_openCloseJoint")
    base = sim.getObjectHandle("plain")
    look("init")
    sim.writeCustomDataBlock(base, "block", sim.packInt32Table([1, 2, 3]))
    sim.setJointTargetVelocity(motor, 0.02)


def sysCall_actuation():
    look("actuation")
    for i in range(1, 6):
        a, b, c = sim.getObjectOrientation(base, -1)
        sim.setObjectOrientation(base, -1, [a, b, c + 0.01 * i])
    numbers = sim.unpackInt32Table(sim.readCustomDataBlock(base, "block"))
    numbers[0] += numbers[2]
    sim.writeCustomDataBlock(base, "block", sim.packInt32Table(numbers))
    note("numbers", numbers)


def sysCall_sensing():
    look("sensing")
    try:
        sim.getObjectPosition(123456, -1)
        note("found")
    except Exception:
        note("not found")
    note("kind", [sim.getObjectType(base), sim.getObjectParent(base), sim.handle_self])
    note("nil" if sim.getStringSignal("nothing") is None else "something")


def sysCall_suspend():
    note("suspend")


def sysCall_resume():
    note("resume")


def sysCall_cleanup():
    look("cleanup")
