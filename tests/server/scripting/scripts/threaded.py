# A thread that moves the finger by waits of every kind while call-backs run.
motor = sim.getObjectHandle("RG2_openCloseJoint")
count = 0


def note(text, number=0):
    sim.addStatusbarMessage("%s %.9g %.9g %d" % (text, sim.getSimulationTime(), number, count))


def sysCall_thread():
    sim.setThreadAutomaticSwitch(False)
    note("begun")
    sim.setJointTargetVelocity(motor, 0.05)
    late = sim.wait(0.23)
    note("waited", late)
    for i in range(1, 4):
        sim.step()
        note("step", i)
    sim.setJointTargetVelocity(motor, -0.05)
    sim.switchThread()
    sim.setIntegerSignal("ready", 7)
    value = sim.waitForSignal("go")
    note("go", value)
    try:
        sim.wait(-1)
        well = True
    except Exception:
        well = False
    note("refused", 1 if well else 0)
    while sim.getJointPosition(motor) > 0:
        sim.switchThread()
    note("closed", sim.getJointPosition(motor))


def sysCall_actuation():
    global count
    count = count + 1
    if count == 14:
        sim.setFloatSignal("go", 2.5)


def sysCall_cleanup():
    note("cleanup")
