"""Cameras (V-REP: vision sensors): images and depths as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_client.protocol import constants as c

from .objects import Object

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from simx_client.calls.answers import Answer
    from simx_client.connection.calls import Calls

_GREY = 1
_HANDLES = 2
"""Render mode in which each pixel is the handle of the visible shape; V-REP's name is
`sim_rendermode_colorcoded`."""
_NOTHING = 0xFFFFFF


class Camera(Object):
    """A camera. It looks along its frame's +z axis; +y is up in the image, -x is right."""

    __slots__ = ()
    object_type = c.sim_object_visionsensor_type

    def rgb(self) -> NDArray[np.uint8]:
        """Return the colour image.

        Returns:
            uint8, height × width × 3: red, green, blue. The top row is first, each row from left to right.
            The array is a copy.
        """
        return self._image(0)

    def grey(self) -> NDArray[np.uint8]:
        """Return the grey image: the mean of the three colours.

        Returns:
            uint8, height × width, the top row first.
        """
        return self._image(_GREY)

    def depth(self) -> NDArray[np.float32]:
        """Return the depth image.

        Returns:
            float32, height × width, the top row first: metres along the viewing axis (not along each ray).
            Pixels without a surface are `far`, surfaces before the near clipping plane are `near`.

        The depth is near + (far - near) * value: the buffer of the legacy call is linear between the clipping
        planes, for perspective and for orthographic cameras.
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
        """Return which shape each pixel shows.

        The camera renders handles (render mode 2) for the time of one message; no other call is executed in
        between. This drops an image that a script has made or kept for the camera. A camera with explicit
        handling sees nothing.

        Returns:
            int32, height × width, the top row first: the handle of the shape, -1 for none, also for bodies
            that are not shapes, such as a cloth.
        """
        import numpy as np

        mode = self._request(
            lambda calls: calls.simxGetObjectIntParameter(self.handle, c.sim_visionintparam_render_mode)
        )

        def render(calls: Calls) -> Answer[Any]:
            calls.simxSetObjectIntParameter(self.handle, c.sim_visionintparam_render_mode, _HANDLES)
            image = calls.simxGetVisionSensorImage(self.handle, 0)
            calls.simxSetObjectIntParameter(self.handle, c.sim_visionintparam_render_mode, mode)
            return image

        _, image = self._request(render)
        codes = image.upright().astype(np.int32) @ np.array([1, 256, 65536], np.int32)
        codes[codes == _NOTHING] = -1
        return codes

    @property
    def resolution(self) -> tuple[int, int]:
        """Return width and height in pixels. The shape of an array has them in the other order."""
        width, height = self._gather(
            lambda calls: (
                calls.simxGetObjectIntParameter(self.handle, c.sim_visionintparam_resolution_x),
                calls.simxGetObjectIntParameter(self.handle, c.sim_visionintparam_resolution_y),
            )
        )
        return width.value, height.value

    @property
    def near(self) -> float:
        """Return the distance to the near clipping plane in metres."""
        return self._parameter(c.sim_visionfloatparam_near_clipping)

    @property
    def far(self) -> float:
        """Return the distance to the far clipping plane in metres."""
        return self._parameter(c.sim_visionfloatparam_far_clipping)

    @property
    def perspective_angle(self) -> float:
        """Return the opening angle across the larger side of the image in radians."""
        return self._parameter(c.sim_visionfloatparam_perspective_angle)

    def _parameter(self, number: int) -> float:
        return self._request(lambda calls: calls.simxGetObjectFloatParameter(self.handle, number))

    def _image(self, options: int) -> NDArray[np.uint8]:
        import numpy as np

        _, image = self._request(lambda calls: calls.simxGetVisionSensorImage(self.handle, options))
        # A copy: the view has negative strides, which OpenCV and PyTorch do not take.
        return np.ascontiguousarray(image.upright())
