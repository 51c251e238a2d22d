# Two programs on one simulation, here as two clients in one file:
#   the MASTER (port 19997) starts everything, sets the pace and moves the cart
#   the WATCHER (port 19999) has its own thread, looks where the cart is and says when it is enough
# They talk through signals:  master -> integer 'step', watcher -> integer 'seen' and string 'message'
import vrep
import sys
import time
import threading

vrep.simxFinish(-1)
master = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)
if master != 0:
    print('no V-REP on port 19997?')
    sys.exit(1)
print('master has id %d' % master)

class Watcher(threading.Thread):
    def __init__(self, port):
        threading.Thread.__init__(self)
        self.daemon = True
        self.id = vrep.simxStart('127.0.0.1', port, True, True, 5000, 5)
        self.result, self.cart = vrep.simxGetObjectHandle(self.id, 'cart', vrep.simx_opmode_blocking)
        self.seen = 0
        self.enough = False

    def run(self):
        # the first answers are no values yet, that is ok
        vrep.simxGetIntegerSignal(self.id, 'step', vrep.simx_opmode_streaming)
        while vrep.simxGetConnectionId(self.id) != -1:
            err, step = vrep.simxGetIntegerSignal(self.id, 'step', vrep.simx_opmode_buffer)
            if err != vrep.simx_return_ok or step == self.seen:
                time.sleep(0.001)
                continue
            if step < 0:    # good bye
                break
            err, pos = vrep.simxGetObjectPosition(self.id, self.cart, -1, vrep.simx_opmode_blocking)
            self.seen = step
            if pos[0] > 0.5 and not self.enough:
                self.enough = True
                vrep.simxSetStringSignal(self.id, 'message', 'enough after %d' % step, vrep.simx_opmode_blocking)
            vrep.simxSetIntegerSignal(self.id, 'seen', step, vrep.simx_opmode_blocking)

vrep.simxSynchronous(master, True)
vrep.simxStartSimulation(master, vrep.simx_opmode_blocking)
watcher = Watcher(19999)
print('watcher has id %d' % watcher.id)
if watcher.id == -1:
    sys.exit('no second port')
watcher.start()

err, motor = vrep.simxGetObjectHandle(master, 'cart_motor', vrep.simx_opmode_blocking)
print('the same handles for both: %s' % (vrep.simxGetObjectHandle(master, 'cart', vrep.simx_opmode_blocking)[1] == watcher.cart))
vrep.simxGetIntegerSignal(master, 'seen', vrep.simx_opmode_streaming)
vrep.simxSetJointTargetVelocity(master, motor, 0.5, vrep.simx_opmode_oneshot)

message = ''
for step in range(1, 61):
    vrep.simxSynchronousTrigger(master)
    vrep.simxSetIntegerSignal(master, 'step', step, vrep.simx_opmode_oneshot)
    # wait for the other one
    while True:
        err, seen = vrep.simxGetIntegerSignal(master, 'seen', vrep.simx_opmode_buffer)
        if err == 0 and seen == step:
            break
        if not watcher.is_alive():
            sys.exit('the watcher is gone')
        time.sleep(0.001)
    err, message = vrep.simxGetStringSignal(master, 'message', vrep.simx_opmode_oneshot_wait)
    if err == vrep.simx_return_ok:
        print('step %d, message: %s' % (step, message.decode('ascii')))
        break

vrep.simxSetJointTargetVelocity(master, motor, 0.0, vrep.simx_opmode_oneshot)
vrep.simxSynchronousTrigger(master)
t1 = vrep.simxGetLastCmdTime(master)
err, pos = vrep.simxGetObjectPosition(master, watcher.cart, -1, vrep.simx_opmode_blocking)
print('stopped at x %.2f' % pos[0])

# the pace is the master's alone: nothing moves while nobody triggers
err, before = vrep.simxGetObjectPosition(watcher.id, watcher.cart, -1, vrep.simx_opmode_blocking)
time.sleep(0.2)
err, after = vrep.simxGetObjectPosition(watcher.id, watcher.cart, -1, vrep.simx_opmode_blocking)
print('frozen without trigger: %s' % (before == after))

vrep.simxSetIntegerSignal(master, 'step', -1, vrep.simx_opmode_blocking)
watcher.join(5)
print('watcher ended: %s' % (not watcher.is_alive()))
vrep.simxFinish(watcher.id)
print('watcher calls after finish: %d' % vrep.simxGetObjectPosition(watcher.id, watcher.cart, -1, vrep.simx_opmode_blocking)[0])
print('master is still there: %s' % (vrep.simxGetConnectionId(master) != -1))
vrep.simxStopSimulation(master, vrep.simx_opmode_blocking)
vrep.simxFinish(master)
