# -*- coding: utf-8 -*-
# UR5 with RG2: take the ball, carry it over, let it go.
# The ball is glued to the gripper (simxSetObjectParent), holding it by friction never worked for me.
import vrep
import math
import time
import sys
import numpy as np

RAD2DEG = 180 / math.pi
jointNum = 6
baseName = 'UR5'
rgName = 'RG2'
jointName = 'UR5_joint'
OVER = [78, -4, 103, -9, -90, -12]      # 15 cm over the ball
GRASP = [78.0, 12.2, 110.7, -32.9, -90.0, -12.0]
PLACE = [30, 12.2, 110.7, -32.9, -90.0, -12.0]

vrep.simxFinish(-1)
while True:
    clientID = vrep.simxStart('127.0.0.1', 19999, True, True, 5000, 5)
    if clientID > -1:
        print("Connection success!")
        break
    else:
        time.sleep(0.2)
        print("Failed connecting to remote API server!")

# on 19999 the simulation runs already; start from scratch, synchronous
vrep.simxStopSimulation(clientID, vrep.simx_opmode_blocking)
while True:     # wait until it has really stopped
    vrep.simxGetPingTime(clientID)
    ok, state = vrep.simxGetInMessageInfo(clientID, vrep.simx_headeroffset_server_state)
    if state & 1 == 0:
        break
vrep.simxSynchronous(clientID, True)
vrep.simxStartSimulation(clientID, vrep.simx_opmode_oneshot)
vrep.simxSynchronousTrigger(clientID)

jointHandle = np.zeros((jointNum,), dtype=np.int64)
for i in range(jointNum):
    _, jointHandle[i] = vrep.simxGetObjectHandle(clientID, jointName + str(i + 1), vrep.simx_opmode_blocking)
ball = vrep.simxGetObjectHandle(clientID, 'Ball', vrep.simx_opmode_blocking)[1]
gripper = vrep.simxGetObjectHandle(clientID, rgName, vrep.simx_opmode_blocking)[1]
connector = vrep.simxGetObjectHandle(clientID, 'RG2_attachPoint#', vrep.simx_opmode_blocking)[1]
finger = vrep.simxGetObjectHandle(clientID, 'RG2_openCloseJoint', vrep.simx_opmode_blocking)[1]

def steps(n):
    for i in range(n):
        vrep.simxSynchronousTrigger(clientID)
    vrep.simxGetPingTime(clientID)

def go(angles, n=60):
    vrep.simxPauseCommunication(clientID, True)
    for i in range(jointNum):
        vrep.simxSetJointTargetPosition(clientID, jointHandle[i], angles[i] / RAD2DEG, vrep.simx_opmode_oneshot)
    vrep.simxPauseCommunication(clientID, False)
    steps(n)
    real = [vrep.simxGetJointPosition(clientID, jointHandle[i], vrep.simx_opmode_blocking)[1] * RAD2DEG for i in range(jointNum)]
    return np.max(np.abs(np.array(real) - np.array(angles)))

def ballAt(text):
    res, pos = vrep.simxGetObjectPosition(clientID, ball, -1, vrep.simx_opmode_oneshot_wait)
    print('%s: ball at x %.2f y %.2f z %.2f' % (text, pos[0], pos[1], pos[2]))
    return pos

# what the simulation tells goes into the status bar and into signals
vrep.simxAddStatusbarMessage(clientID, 'pick and place starts', vrep.simx_opmode_oneshot)
vrep.simxSetStringSignal(clientID, 'phase', 'approach', vrep.simx_opmode_oneshot)
print('parent of the ball:', vrep.simxGetObjectParent(clientID, ball, vrep.simx_opmode_blocking)[1])
start = ballAt('start')

print('over the ball, off by %d deg' % go(OVER))
print('around the ball, off by %d deg' % go(GRASP, 40))

vrep.simxSetStringSignal(clientID, 'phase', 'grasp', vrep.simx_opmode_oneshot)
vrep.simxSetIntegerSignal(clientID, 'RG2_open', 0, vrep.simx_opmode_oneshot)
steps(20)
res, gap = vrep.simxGetJointPosition(clientID, finger, vrep.simx_opmode_blocking)
print('gripper at %.2f' % gap)
res = vrep.simxSetObjectParent(clientID, ball, connector, True, vrep.simx_opmode_blocking)
print('attached:', res == vrep.simx_return_ok, vrep.simxGetObjectParent(clientID, ball, vrep.simx_opmode_blocking)[1] == connector)

go(OVER, 40)
lifted = ballAt('lifted')
print('off the floor:', lifted[2] > start[2] + 0.05)
res, rel0 = vrep.simxGetObjectPosition(clientID, ball, gripper, vrep.simx_opmode_blocking)
go(PLACE, 80)
res, rel1 = vrep.simxGetObjectPosition(clientID, ball, gripper, vrep.simx_opmode_blocking)
print('did not slip:', np.allclose(rel0, rel1, atol=0.003))

vrep.simxSetStringSignal(clientID, 'phase', 'place', vrep.simx_opmode_oneshot)
vrep.simxSetObjectParent(clientID, ball, -1, True, vrep.simx_opmode_blocking)
vrep.simxSetIntegerSignal(clientID, 'RG2_open', 1, vrep.simx_opmode_oneshot)
steps(20)
end = ballAt('let go')
print('on the floor: %s, carried %.1f m' % (end[2] < 0.03, math.hypot(end[0] - start[0], end[1] - start[1])))

res, phase = vrep.simxGetStringSignal(clientID, 'phase', vrep.simx_opmode_blocking)
print('phase:', phase.decode('ascii'))
vrep.simxClearStringSignal(clientID, 'phase', vrep.simx_opmode_blocking)
res, phase = vrep.simxGetStringSignal(clientID, 'phase', vrep.simx_opmode_blocking)
print('after clearing it: code %d, %d bytes' % (res, len(phase)))

vrep.simxStopSimulation(clientID, vrep.simx_opmode_oneshot_wait)
ballAt('after stop')
print('parent again:', vrep.simxGetObjectParent(clientID, ball, vrep.simx_opmode_blocking)[1])
vrep.simxClearIntegerSignal(clientID, 'RG2_open', vrep.simx_opmode_oneshot)
vrep.simxGetPingTime(clientID)
vrep.simxFinish(clientID)
sys.exit(0)
