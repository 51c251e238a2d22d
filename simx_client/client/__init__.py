"""Provide typed objects, arrays and exceptions for new code, over the same table as the legacy functions.

    from simx_client import Client

    with Client("127.0.0.1", 19997) as client:
        print(client.joint("UR5_joint1").position, client.camera("kinect_rgb").rgb().shape)

``client`` is the entry point; ``scene`` finds objects, which are in ``objects``, ``joints``, ``camera``, ``sensors``;
``channel`` makes the calls, ``stepping`` puts a simulation step into one message; ``servers`` steps many servers
together, ``worlds`` many simulations in this process. ``docs/python.md`` lists each legacy call beside its counterpart
here. The exceptions are in ``simx_client.errors``.
"""

from simx_client.calls.answers import Answer
from simx_client.connection.calls import Calls

from .client import Client, Results
from .scene.camera import Camera
from .scene.joints import Joint, Joints
from .scene.listing import Objects
from .scene.objects import Dummy, Object, SceneObject, Shape
from .scene.poses import Place, Pose
from .scene.sensors import Detection, ForceSensor, ProximitySensor, Wrench
from .servers import Servers
from .signals import Signals
from .simulation import Simulation, State
from .stepping import Stepping
from .watching import Watch
from .worlds import Worlds

__all__ = [
    "Answer",
    "Calls",
    "Camera",
    "Client",
    "Detection",
    "Dummy",
    "ForceSensor",
    "Joint",
    "Joints",
    "Object",
    "Objects",
    "Place",
    "Pose",
    "ProximitySensor",
    "Results",
    "SceneObject",
    "Servers",
    "Shape",
    "Signals",
    "Simulation",
    "State",
    "Stepping",
    "Watch",
    "Worlds",
    "Wrench",
]
