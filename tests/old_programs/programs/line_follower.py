# line follower with the camera in front of the robot
# the picture is grey, one row is enough. Careful, V-REP gives SIGNED bytes:
#    0..127 is dark to medium, and what is brighter than medium comes as -128..-1 !
import vrep
import sys
import time
import numpy as np

print('Program started')
vrep.simxFinish(-1)
clientID = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)
if clientID == -1:
    print('Failed connecting to remote API server')
    sys.exit()
print('Connected to remote API server')

res, camera = vrep.simxGetObjectHandle(clientID, 'Vision_sensor', vrep.simx_opmode_oneshot_wait)
res, left = vrep.simxGetObjectHandle(clientID, 'LineTracer_leftJoint', vrep.simx_opmode_oneshot_wait)
res, right = vrep.simxGetObjectHandle(clientID, 'LineTracer_rightJoint', vrep.simx_opmode_oneshot_wait)
res, robot = vrep.simxGetObjectHandle(clientID, 'LineTracer', vrep.simx_opmode_oneshot_wait)

vrep.simxSynchronous(clientID, 1)
vrep.simxStartSimulation(clientID, vrep.simx_opmode_blocking)

# first call: streaming, and wait until there is a picture
err, resolution, image = vrep.simxGetVisionSensorImage(clientID, camera, 1, vrep.simx_opmode_streaming)
print('first call: %d, %d values' % (err, len(image)))
while True:
    vrep.simxSynchronousTrigger(clientID)
    vrep.simxGetPingTime(clientID)
    err, resolution, image = vrep.simxGetVisionSensorImage(clientID, camera, 1, vrep.simx_opmode_buffer)
    if err == vrep.simx_return_ok:
        break
    elif err == vrep.simx_return_novalue_flag:
        time.sleep(0.01)
    else:
        print('error', err)
        break
width, height = resolution
print('picture %d x %d, white is %d, a line is in it: %s' % (width, height, image[-1], max(image) < 60))

def darkColumns(image):
    # third row from below; dark means 0..60, bright ones are negative
    row = image[3 * width:4 * width]
    found = []
    for col in range(width):
        if row[col] >= 0 and row[col] < 60:
            found.append(col)
    return found

lost = 0
errors = []
ping = 0
last = 0.0
for step in range(140):
    err, resolution, image = vrep.simxGetVisionSensorImage(clientID, camera, 1, vrep.simx_opmode_buffer)
    dark = darkColumns(image)
    if len(dark) > 0:
        last = sum(dark) / float(len(dark)) - (width - 1) / 2.0   # + is right of the middle
        errors.append(abs(last))
    else:
        lost = lost + 1
    vl = 8.0 + 0.5 * last
    vr = 8.0 - 0.5 * last
    vrep.simxPauseCommunication(clientID, True)
    vrep.simxSetJointTargetVelocity(clientID, left, vl, vrep.simx_opmode_oneshot)
    vrep.simxSetJointTargetVelocity(clientID, right, vr, vrep.simx_opmode_oneshot)
    vrep.simxPauseCommunication(clientID, False)
    vrep.simxSynchronousTrigger(clientID)
    vrep.simxGetPingTime(clientID)
    if step % 35 == 34:
        p = vrep.simxGetObjectPosition(clientID, robot, -1, vrep.simx_opmode_blocking)[1]
        print('step %d at x %.2f y %.2f' % (step + 1, p[0], p[1]))

print('lost the line %d times' % lost)
print('mean error %.0f columns' % np.mean(errors))

# whole picture as everybody does it
img = np.array(image, dtype=np.uint8)
img.resize([resolution[1], resolution[0]])
img = np.flipud(img)
print('as uint8: white is %d, shape %s' % (img.max(), img.shape))

vrep.simxGetVisionSensorImage(clientID, camera, 1, vrep.simx_opmode_discontinue)
vrep.simxStopSimulation(clientID, vrep.simx_opmode_oneshot_wait)
vrep.simxGetPingTime(clientID)
vrep.simxFinish(clientID)
print('Program ended')
