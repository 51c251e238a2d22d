"""Test one OpenGL back end in a child process: `python -m simx_server.sensors.opengl.probe NAME`.

Exit status 0 if a small image has the right pixels, otherwise 1 and the reason as the last line of stderr. The
libraries are checked before anything large is imported.
"""

import sys

from simx_server.errors import RenderError

from .libraries import missing_libraries, why_it_fails

_SCENE = """
<mujoco>
  <worldbody>
    <geom type="box" size="0.1 0.1 0.1" rgba="1 0 0 1"/>
    <camera name="eye" pos="0 0 1.1"/>
  </worldbody>
</mujoco>
"""


def check_backend(name: str) -> None:
    """Render a red box seen from above, and check its colour, its edge and its depth.

    Raises:
        RenderError: the context cannot be made, or the image is wrong.
    """
    import mujoco
    import numpy as np

    from simx_server.scene.cameras.image import CameraView

    from .renderer import OpenGLRenderer

    model = mujoco.MjModel.from_xml_string(_SCENE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    view = CameraView(camera_id=0, width=32, height=24, fovy_deg=45.0, near=0.1, far=2.1)
    renderer = OpenGLRenderer(model, name)
    try:
        picture = renderer.render(data, view, rgb=True, depth=True)
    finally:
        renderer.close()
    assert picture.rgb is not None
    assert picture.depth is not None
    red, green, blue = (int(value) for value in picture.rgb[12, 16])
    if not red > green + 20 or not red > blue + 20 or np.any(picture.rgb[0, 0]):
        raise RenderError(f"the test picture has wrong colours: ({red}, {green}, {blue}) where red belongs")
    # The box's top is 1 m away, 0.9 of the 2 m between the planes.
    if abs(float(picture.depth[12, 16]) - 0.45) > 0.004 or picture.depth[0, 0] != 1.0:
        raise RenderError(f"the test picture has wrong depth: {picture.depth[12, 16]:.3f} where 0.45 belongs")


def what_is_wrong(name: str) -> str | None:
    """Try a back end in this process; return None if it works, else the problem. The driver may crash or hang."""
    if missing := missing_libraries(name):
        return missing
    try:
        check_backend(name)
    except Exception as error:
        wrong = str(error) if error.__cause__ is None else why_it_fails(name, error.__cause__)
        return " ".join(wrong.split()) or type(error).__name__
    return None


def main(arguments: list[str]) -> int:
    if wrong := what_is_wrong(arguments[0]):
        sys.stderr.write(f"{wrong}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
