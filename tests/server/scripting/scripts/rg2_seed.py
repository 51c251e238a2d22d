# The tutorial's gripper script, line by line in Python.
def rg2Close(inInts, inFloats, inStrings, inBuffer):
    v = -self.motorVelocity
    sim.setJointForce(self.motorHandle, self.motorForce)
    sim.setJointTargetVelocity(self.motorHandle, v)
    return [], [v], [], ""


def rg2Open(inInts, inFloats, inStrings, inBuffer):
    v = self.motorVelocity
    sim.setJointForce(self.motorHandle, self.motorForce)
    sim.setJointTargetVelocity(self.motorHandle, v)
    return [], [v], [], ""


def sysCall_init():
    self.motorHandle = sim.getObjectHandle("RG2_openCloseJoint")
    self.motorVelocity = 0.05  # m/s
    self.motorForce = 20  # N
    rg2Open([], [], [], "")
