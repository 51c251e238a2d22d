# Commands come as signals, one letter each; answers go back as signals of every type.
served = 0


def open_it():
    sim.setJointTargetVelocity(motor, 0.05)


def close_it():
    sim.setJointTargetVelocity(motor, -0.05)


def pack():
    data = sim.packFloatTable([sim.getJointPosition(motor), served, -1.5])
    assert isinstance(data, bytes)
    sim.setStringSignal("packed", data)


def unpack():
    values = sim.unpackFloatTable(sim.getStringSignal("packed"))
    sim.setFloatSignal("unpacked", sum(values))


def move():
    x, y, z = sim.getObjectPosition(base, -1)
    sim.setObjectPosition(base, -1, [x + 0.01, y, z])


commands = {"o": open_it, "c": close_it, "p": pack, "q": unpack, "m": move}


def sysCall_init():
    global motor, base
    motor = sim.getObjectHandle("RG2_openCloseJoint")
    base = sim.getObjectHandle("plain")
    sim.setIntegerSignal("served", served)


def sysCall_actuation():
    global served
    text = sim.getStringSignal("commands")
    if text is None:
        return
    sim.clearStringSignal("commands")
    for letter in text:
        if letter in commands:
            commands[letter]()
            served += 1
        else:
            sim.addStatusbarMessage("unknown: " + letter)
    sim.setIntegerSignal("served", served)


def answer(ints, floats, strings, buffer):
    buffer = buffer.encode() if isinstance(buffer, str) else buffer
    return [sum(ints), served], [number / 2 for number in floats], [*strings, "more"], buffer + b"\xff\0x"
