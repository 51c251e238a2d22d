#!/usr/bin/env python
# -*- coding: utf-8 -*-
#
# Pioneer p3dx wanders through a room with boxes and keeps off everything (Braitenberg).
# Python 2.7. Start V-REP with pioneer_room first, port 19997.
#
#   python pioneer_avoid.py [seconds]

import vrep
import sys, math, string

PI = math.pi
noDetectionDist = 0.8
maxDetectionDist = 0.2
v0 = 3
# left wheel, right wheel; sensors 1..8 are in front
braitenbergL = [-0.2, -0.4, -0.6, -0.8, -1.0, -1.2, -1.4, -1.6]
braitenbergR = [-1.6, -1.4, -1.2, -1.0, -0.8, -0.6, -0.4, -0.2]

if len(sys.argv) > 1:
    seconds = string.atoi(sys.argv[1])
else:
    seconds = 16

vrep.simxFinish(-1) # just in case, close all opened connections
clientID = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)
if clientID <> -1:
    print 'Connected to remote API server'
else:
    print 'Connection not successful'
    sys.exit('Could not connect')

class Robot:
	def __init__(self, name):
		self.name = name
		errorCode, self.body = vrep.simxGetObjectHandle(clientID, name, vrep.simx_opmode_oneshot_wait)
		errorCode, self.left = vrep.simxGetObjectHandle(clientID, name + '_leftMotor', vrep.simx_opmode_oneshot_wait)
		errorCode, self.right = vrep.simxGetObjectHandle(clientID, name + '_rightMotor', vrep.simx_opmode_oneshot_wait)
		self.sensors = {}
		for i in xrange(1, 16 + 1):
			err, h = vrep.simxGetObjectHandle(clientID, '%s_ultrasonicSensor%d' % (name, i), vrep.simx_opmode_oneshot_wait)
			if err <> 0:
				raise RuntimeError, 'no sensor %d' % i
			self.sensors[i] = h
			# first call, starts the stream
			vrep.simxReadProximitySensor(clientID, h, vrep.simx_opmode_streaming)
		vrep.simxGetObjectPosition(clientID, self.body, -1, vrep.simx_opmode_streaming)
		vrep.simxGetObjectOrientation(clientID, self.body, -1, vrep.simx_opmode_streaming)

        def look(self):
                "distance to whatever the front sensors see, 0..1 for danger"
                detect = [0] * 8
                for i in filter(lambda k: k <= 8, self.sensors.keys()):
                        returnCode, state, point, obj, normal = vrep.simxReadProximitySensor(clientID, self.sensors[i], vrep.simx_opmode_buffer)
                        if returnCode == vrep.simx_return_ok and state:
                                dist = math.sqrt(point[0]**2 + point[1]**2 + point[2]**2)
                                if dist < noDetectionDist:
                                        if dist < maxDetectionDist: dist = maxDetectionDist
                                        detect[i - 1] = 1 - (dist - maxDetectionDist) / (noDetectionDist - maxDetectionDist)
                return detect

	def drive(self, vl, vr):
		vrep.simxSetJointTargetVelocity(clientID, self.left, vl, vrep.simx_opmode_streaming)
		vrep.simxSetJointTargetVelocity(clientID, self.right, vr, vrep.simx_opmode_streaming)

	def where(self):
		pos = vrep.simxGetObjectPosition(clientID, self.body, -1, vrep.simx_opmode_buffer)[1]
		ang = vrep.simxGetObjectOrientation(clientID, self.body, -1, vrep.simx_opmode_buffer)[1]
		return pos[0], pos[1], ang[2]

try:
    robot = Robot('Pioneer_p3dx')
except RuntimeError, e:
    print 'the scene is not the right one:', e
    sys.exit(1)
print 'handles are there:', len(robot.sensors), 'sensors'

vrep.simxSynchronous(clientID, True)
vrep.simxStartSimulation(clientID, vrep.simx_opmode_oneshot)

steps = seconds * 20   # 50 ms each
closest = 9.9
turns = 0
danger = 0
log = []
for step in range(steps):
    vrep.simxSynchronousTrigger(clientID)
    vrep.simxGetPingTime(clientID)
    detect = robot.look()
    vLeft = vRight = v0
    for i in range(8):
        vLeft = vLeft + braitenbergL[i] * detect[i]
        vRight = vRight + braitenbergR[i] * detect[i]
    robot.drive(vLeft, vRight)
    if max(detect) > 0:
        danger += 1
        closest = min(closest, noDetectionDist - max(detect) * (noDetectionDist - maxDetectionDist))
    if step % (steps / 4) == steps / 4 - 1:
        x, y, gamma = robot.where()
        log.append((x, y, gamma))
        print '%d%%' % (100 * (step + 1) / steps), 'x %.2f' % x, 'y %.2f' % y, 'heading %d deg' % (gamma * 180 / PI)

print 'something near in', danger * 100 / steps, 'percent of the steps, never nearer than', `round(closest, 1)`
inside = [p for p in log if abs(p[0]) < 2 and abs(p[1]) < 2]
print 'in the room all the time:', len(inside) == len(log)

robot.drive(0, 0)
vrep.simxStopSimulation(clientID, vrep.simx_opmode_oneshot_wait)
vrep.simxFinish(clientID)
print 'bye'
