"""
Keeps an inverted pendulum upright with joint TORQUES.

V-REP's remote API has no torque command. The trick: give the motor a target velocity it can never reach, with the
sign of the torque, and limit the force to the torque wanted.
Must run synchronous, one trigger per control step!
"""
import vrep, sys
from math import sin, pi

dt = .01        # s, set below. The scene must be in 'custom' dt mode
kp, kd = 60.0, 12.0
maxTorque = 20.0

def check(err, what):
    if err != vrep.simx_return_ok and err != vrep.simx_return_novalue_flag:
        raise Exception('failed: ' + what + ', error code ' + str(err))

vrep.simxFinish(-1)
cid = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)
if cid != -1:
    print('Connected to V-REP remote API server, client id', cid)
else:
    print('Failed connecting to V-REP remote API server')
    sys.exit(1)

err, joint = vrep.simxGetObjectHandle(cid, 'pendulum_joint', vrep.simx_opmode_blocking)
check(err, 'handle')
check(vrep.simxSetFloatingParameter(cid, vrep.sim_floatparam_simulation_time_step, dt, vrep.simx_opmode_oneshot), 'dt')
check(vrep.simxSetJointPosition(cid, joint, 0.3, vrep.simx_opmode_oneshot), 'start angle')
check(vrep.simxSynchronous(cid, True), 'synchronous')
check(vrep.simxStartSimulation(cid, vrep.simx_opmode_blocking), 'start')
_, step_set = vrep.simxGetFloatingParameter(cid, vrep.sim_floatparam_simulation_time_step, vrep.simx_opmode_blocking)
print('time step is %.3f s' % step_set)

# velocity of the joint is object parameter 2012
vrep.simxGetJointPosition(cid, joint, vrep.simx_opmode_streaming)
vrep.simxGetObjectFloatParameter(cid, joint, 2012, vrep.simx_opmode_streaming)
vrep.simxGetJointForce(cid, joint, vrep.simx_opmode_streaming)

q, dq = 0.3, 0.0
t = 0
t0 = None
biggest = 0.0
kicked = False
signs = []
while True:
    # lean to one side, then to the other
    if t // 500 % 2 == 0:
        goal = 0.2
    else:
        goal = -0.2
    u = kp * (goal - q) - kd * dq
    u = max(-maxTorque, min(maxTorque, u))
    if u < 0:
        velocity = -1000.0
    else:
        velocity = 1000.0
    vrep.simxPauseCommunication(cid, 1)
    vrep.simxSetJointTargetVelocity(cid, joint, velocity, vrep.simx_opmode_oneshot)
    vrep.simxSetJointForce(cid, joint, abs(u), vrep.simx_opmode_oneshot)
    vrep.simxPauseCommunication(cid, 0)

    vrep.simxSynchronousTrigger(cid)
    vrep.simxGetPingTime(cid)       # now the step is done

    err, q = vrep.simxGetJointPosition(cid, joint, vrep.simx_opmode_buffer)
    check(err, 'position')
    err, dq = vrep.simxGetObjectFloatParameter(cid, joint, 2012, vrep.simx_opmode_buffer)
    check(err, 'velocity')
    err, f = vrep.simxGetJointForce(cid, joint, vrep.simx_opmode_buffer)
    if abs(u) > 1:
        signs.append(f * u > 0 or f * u < 0)    # the sign depends on the version, only say that it is there

    t = vrep.simxGetLastCmdTime(cid)    # ms of simulated time, our clock
    if t0 is None:
        t0 = t
        print('clock starts at %d ms' % t)
    if t % 500 == 490:
        print('t = %4d ms   q = %6.2f rad' % (t, q))
    if t >= 1250 and not kicked:
        kicked = True       # let go for a moment
        vrep.simxSetJointForce(cid, joint, 0.0, vrep.simx_opmode_oneshot)
        for i in range(15):
            vrep.simxSynchronousTrigger(cid)
        vrep.simxGetPingTime(cid)
        print('let go for %d ms' % (vrep.simxGetLastCmdTime(cid) - t))
    biggest = max(biggest, abs(q))
    if t >= 3000:
        break

print('never more than %d degrees off' % round(biggest * 180 / pi))
print('forces read back: %s' % (len(signs) > 10 and all(signs)))
vrep.simxStopSimulation(cid, vrep.simx_opmode_blocking)
err, q = vrep.simxGetJointPosition(cid, joint, vrep.simx_opmode_blocking)
print('after stop %.2f' % q)
vrep.simxFinish(cid)
