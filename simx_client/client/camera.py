"""What V-REP calls a vision sensor: colours and depths as arrays, as one looks at a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_client.protocol import constants as c

from .objects import Object

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from simx_client.connection.answers import Answer
    from simx_client.connection.calls import Calls

_GREY = 1
_HANDLES = 2
"""The render mode in which each pixel is the handle of what is seen; V-REP's name is `sim_rendermode_colorcoded`."""
_NOTHING = 0xFFFFFF


class Camera(Object):
    """A camera: it looks along its frame's +z axis, up in the picture is +y, right is -x."""

    __slots__ = ()
    object_type = c.sim_object_visionsensor_type

    def rgb(self) -> NDArray[np.uint8]:
        """Height × width × 3, red, green, blue; the top row first, each from left to right. The array is your own."""
        return self._picture(0)

    def grey(self) -> NDArray[np.uint8]:
        """Height × width, the mean of the three colours; the top row first."""
        return self._picture(_GREY)

    def depth(self) -> NDArray[np.float32]:
        """Height × width, metres along the viewing axis (not along each ray); the top row first.

        It is near + (far - near) * value: the buffer of the legacy call is linear between the clipping planes,
        for perspective and for orthographic cameras. Where nothing is nearer it is ``far``, what is too near is
        ``near``.
        """
        import numpy as np

        buffer, near, far = self._gather(
            lambda calls: (
                calls.simxGetVisionSensorDepthBuffer(self.handle),
                calls.simxGetObjectFloatParameter(self.handle, c.sim_visionfloatparam_near_clipping),
                calls.simxGetObjectFloatParameter(self.handle, c.sim_visionfloatparam_far_clipping),
            )
        )
        upright = buffer.value[1].upright()
        return np.float32(near.value) + upright * np.float32(far.value - near.value)

    def objects(self) -> NDArray[np.int32]:
        """Height × width, the handle of the shape that each pixel shows, -1 where there is none; the top row first.

        What belongs to no shape, a cloth for example, is -1 too. The sensor shows handles (its render mode is 2) for
        the time of one message, which nothing comes between. A picture that a script has made or kept for it is
        dropped by that, and a sensor which is handled explicitly only sees nothing.
        """
        import numpy as np

        mode = self._ask(
            lambda calls: calls.simxGetObjectIntParameter(self.handle, c.sim_visionintparam_render_mode)
        )

        def look(calls: Calls) -> Answer[Any]:
            calls.simxSetObjectIntParameter(self.handle, c.sim_visionintparam_render_mode, _HANDLES)
            picture = calls.simxGetVisionSensorImage(self.handle, 0)
            calls.simxSetObjectIntParameter(self.handle, c.sim_visionintparam_render_mode, mode)
            return picture

        _, image = self._ask(look)
        codes = image.upright().astype(np.int32) @ np.array([1, 256, 65536], np.int32)
        codes[codes == _NOTHING] = -1
        return codes

    @property
    def resolution(self) -> tuple[int, int]:
        """Width and height in pixels. An array's shape is the other way round."""
        width, height = self._gather(
            lambda calls: (
                calls.simxGetObjectIntParameter(self.handle, c.sim_visionintparam_resolution_x),
                calls.simxGetObjectIntParameter(self.handle, c.sim_visionintparam_resolution_y),
            )
        )
        return width.value, height.value

    @property
    def near(self) -> float:
        """Metres to the near clipping plane."""
        return self._parameter(c.sim_visionfloatparam_near_clipping)

    @property
    def far(self) -> float:
        """Metres to the far clipping plane."""
        return self._parameter(c.sim_visionfloatparam_far_clipping)

    @property
    def perspective_angle(self) -> float:
        """Radians across the larger side of the picture."""
        return self._parameter(c.sim_visionfloatparam_perspective_angle)

    def _parameter(self, number: int) -> float:
        return self._ask(lambda calls: calls.simxGetObjectFloatParameter(self.handle, number))

    def _picture(self, options: int) -> NDArray[np.uint8]:
        import numpy as np

        _, image = self._ask(lambda calls: calls.simxGetVisionSensorImage(self.handle, options))
        # A copy: the view has negative strides, which OpenCV and PyTorch do not take.
        return np.ascontiguousarray(image.upright())
