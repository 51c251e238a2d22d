"""Images of vision sensors. They are rendered on the render thread: the handlers return futures of wire bytes."""

from __future__ import annotations

from concurrent.futures import Future
from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.world.world import World

_GREY = 1
"""The option bit of a grey image."""


@handler("simxGetVisionSensorImage", with_client=True)
def get_vision_sensor_image(
    world: World, client: ClientSession, sensor: int, options: int
) -> Future[tuple[list[int], bytes]]:
    """Return [width, height] and bytes: grey with any option bit (the binding then expects w x h).

    Differs: with other options than 1 the original sent colours, of which its binding then took the first third; and
    while stopped, or before the first simulation step, it returned the background.
    """
    return world.vision.image(sensor, as_grey=options != 0, asker=client.client)


@handler("simxGetVisionSensorDepthBuffer", with_client=True)
def get_vision_sensor_depth_buffer(
    world: World, client: ClientSession, sensor: int
) -> Future[tuple[list[int], bytes]]:
    """Return [width, height] and little-endian float32, 0 at the near plane, 1 at the far one."""
    return world.vision.depth(sensor, asker=client.client)


@handler("simxSetVisionSensorImage")
def set_vision_sensor_image(world: World, sensor: int, image: bytes, options: int) -> None:
    """Keep the image until the sensor is handled next: in the next simulation step, or by a script.

    Differs: with external input the stop removes the image, as all other changes of a run; in V-REP it stayed.

    Raises:
        CommandError: not w x h x 3 bytes (w x h with option bit 0).
    """
    world.vision.set_image(sensor, image, as_grey=bool(options & _GREY))
