"""What V-REP calls a vision sensor: colours and depths as arrays, as one looks at a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..protocol import constants as c
from .objects import Object

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_GREY = 1


class Camera(Object):
    """A camera: it looks along its frame's +z axis, up in the picture is +y, right is -x."""

    object_type = c.sim_object_visionsensor_type
    kind = "camera"

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
