"""The roles of the soak's clients: one function for each role, called again and again with a connected client.

Each returns after a second or so, at latest when its connection has gone; what it leaves behind (streams, stepped mode,
objects) it leaves on purpose, as scripts do that end or die.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable

import simx_client as v

BLOCKING, ONESHOT = v.simx_opmode_blocking, v.simx_opmode_oneshot
STREAMING, BUFFER, REMOVE = v.simx_opmode_streaming, v.simx_opmode_buffer, v.simx_opmode_remove
RESOLUTION_X = v.sim_visionintparam_resolution_x

Role = Callable[[int, random.Random, str], None]
"""Of a client id, a source of chance and the path of the scene."""


def pictures(cid: int, chance: random.Random, scene: str) -> None:
    """Streams of images and depths, pictures on demand, other resolutions."""
    found = [v.simxGetObjectHandle(cid, name, BLOCKING) for name in ("colour", "distance")]
    cameras = [handle for code, handle in found if code == 0]
    for camera in cameras:
        v.simxSetObjectIntParameter(cid, camera, RESOLUTION_X, chance.choice([8, 32, 128]), BLOCKING)
        v.simxGetVisionSensorImage(cid, camera, chance.choice([0, 1]), STREAMING)
        v.simxGetVisionSensorDepthBuffer(cid, camera, STREAMING)
        v.simxReadVisionSensor(cid, camera, STREAMING)
    end = time.monotonic() + chance.uniform(0.2, 1.0)
    while time.monotonic() < end and v.simxGetConnectionId(cid) != -1:
        for camera in cameras:
            v.simxGetVisionSensorImage(cid, camera, 0, BUFFER)
            v.simxGetVisionSensorImage(cid, camera, 0, BLOCKING)
        time.sleep(0.02)
    if cameras and chance.random() < 0.5:
        v.simxSetVisionSensorImage(cid, cameras[0], bytes(3 * 8 * 6), 0, ONESHOT)
        v.simxGetVisionSensorImage(cid, cameras[0], 0, REMOVE)


def stepping(cid: int, chance: random.Random, scene: str) -> None:
    """Stepped mode: pass for pass, with targets set and positions read between, all in one batch or one by one."""
    v.simxSynchronous(cid, True)
    v.simxStartSimulation(cid, BLOCKING)
    joint = v.simxGetObjectHandle(cid, "shoulder", BLOCKING)[1]
    for _ in range(chance.randrange(5, 60)):
        if chance.random() < 0.3:
            v.simxPauseCommunication(cid, True)
        v.simxSetJointTargetVelocity(cid, joint, chance.uniform(-2, 2), ONESHOT)
        v.simxSynchronousTrigger(cid)
        v.simxPauseCommunication(cid, False)
        v.simxGetJointPosition(cid, joint, BLOCKING)
        if v.simxGetConnectionId(cid) == -1:
            return
    if chance.random() < 0.7:
        v.simxSynchronous(cid, False)
    if chance.random() < 0.3:
        v.simxStopSimulation(cid, BLOCKING)


def editing(cid: int, chance: random.Random, scene: str) -> None:
    """Models in, copies, other parents, objects out; now and then the scene again, also one of the client's side."""
    if chance.random() < 0.2 or len(v.simxGetObjects(cid, v.sim_handle_all, BLOCKING)[1] or []) > 60:
        v.simxStopSimulation(cid, BLOCKING)
        v.simxLoadScene(cid, scene, chance.choice([0, 1]), BLOCKING)
    crate = v.simxGetObjectHandle(cid, "crate", BLOCKING)[1]
    code, copies = v.simxCopyPasteObjects(cid, [crate], BLOCKING)
    for handle in (copies or []) if code == 0 else []:
        dummy = v.simxCreateDummy(cid, 0.1, None, BLOCKING)[1]
        v.simxSetObjectParent(cid, handle, dummy, True, BLOCKING)
        v.simxSetObjectPosition(cid, handle, -1, [chance.uniform(-1, 1) for _ in range(3)], ONESHOT)
        v.simxRemoveModel(cid, handle, BLOCKING)
        if chance.random() < 0.8:
            v.simxRemoveObject(cid, dummy, BLOCKING)
    code, model = v.simxLoadModel(cid, "jaco_arm", 0, BLOCKING) if chance.random() < 0.2 else (1, -1)
    if code == 0 and chance.random() < 0.8:
        v.simxRemoveModel(cid, model, BLOCKING)


def coming_and_going(cid: int, chance: random.Random, scene: str) -> None:
    """Streams of many kinds, some values of them, and away."""
    handles = v.simxGetObjects(cid, v.sim_handle_all, BLOCKING)[1] or [1]
    for handle in chance.sample(handles, min(8, len(handles))):
        v.simxGetObjectPosition(cid, handle, -1, STREAMING)
        v.simxGetObjectOrientation(cid, handle, -1, STREAMING + chance.choice([0, 100]))
        v.simxGetJointForce(cid, handle, STREAMING)
    v.simxGetObjectGroupData(cid, v.sim_object_joint_type, 15, STREAMING)
    v.simxSetStringSignal(cid, f"of {chance.randrange(20)}", chance.randbytes(1000), ONESHOT)
    v.simxGetStringSignal(cid, f"of {chance.randrange(20)}", STREAMING)
    time.sleep(chance.uniform(0.0, 0.2))


ROLES: dict[str, Role] = {
    "pictures": pictures,
    "stepping": stepping,
    "editing": editing,
    "coming": coming_and_going,
}
"""Beside ``mixed``, the random calls of `soak_client.py`."""
