"""Commands to OpenGL between MuJoCo's own, for a background, light and transparency as V-REP has them.

MuJoCo sets OpenGL's state itself each time it draws: the background is black, highlights are computed for an eye at
the camera, and what is transparent is drawn twice, from front to back and from back to front, without depth. V-REP
computed highlights, which have colours, for an eye far away, and drew what is transparent once, from back to front,
with depth.

MuJoCo draws a mesh by calling a display list, whose number the geom has. A geom with the number of another list runs
the commands in that list when its turn comes, and draws nothing.

Such a geom before each other one gives its number to the stencil buffer, which then says what each pixel shows.
"""

from __future__ import annotations

import ctypes
import functools
import importlib
from collections.abc import Callable
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .drawn_geoms import DrawnGeoms

_FAR = 1e15
"""Distance beyond everything; MuJoCo takes 1e10 for planes that are seen from behind."""

_BEFORE_PLANES = 4e9, 5e9
"""Distances beyond everything but such planes."""

Color = tuple[float, float, float]

COUNT = 5
"""Geoms that are added to a scene."""

MOST_NUMBERS = 255
"""Geoms that can be numbered in one image: the stencil buffer has a byte for each pixel, and 0 is nothing."""

_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)
_SOLIDS = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): 0,
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): 0,
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): 3,
    int(mujoco.mjtGeom.mjGEOM_BOX): 6,
}
"""Kinds of geoms that MuJoCo draws as one of its built-in lists, and the number of the list."""

_ROLES = int(mujoco.mjtTextureRole.mjNTEXROLE)
_RGB = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)

_NO_ROTATION = np.eye(3).ravel()


class Commands:
    """One of MuJoCo's contexts with its display lists; its OpenGL context must be current whenever they are used."""

    def __init__(self, drawing: mujoco.MjrContext) -> None:
        # Imported late: a back end must choose PyOpenGL's platform before.
        self._gl: Any = importlib.import_module("OpenGL.raw.GL.VERSION.GL_1_1")
        self._framebuffers: Any = importlib.import_module("OpenGL.raw.GL.VERSION.GL_3_0")
        gl = self._gl
        self._numbering: list[int] = []
        """The lists that number geoms: that of number 1, 2, ..."""

        self.drawing, self._numbers = drawing, list[int]()
        self._background: Color | None = None
        self._tinted: dict[int, tuple[tuple[Any, ...], int]] = {}
        """The content and number of each geom's list, by MuJoCo's id of the geom."""
        try:
            self._start = self._list_of(lambda: None)
            self._hide = self._list_of(lambda: gl.glColorMask(False, False, False, False))
            self._show = self._list_of(lambda: gl.glColorMask(True, True, True, True))
            self._with_depth = self._list_of(lambda: gl.glDepthMask(True))
            self._without_depth = self._list_of(lambda: gl.glDepthMask(False))
        except BaseException:
            self.free()  # later, with another context current, its numbers would be those of others
            raise

    def add(self, scene: mujoco.MjvScene, geoms: DrawnGeoms, background: Color) -> None:
        """Add the commands to a scene that is drawn with colours.

        Args:
            scene: the scene, with room for `COUNT` geoms.
            geoms: its geoms.
            background: RGB 0..1.
        """
        self._set_start(background)
        eye = np.mean([camera.pos for camera in scene.camera], axis=0)
        added = slice(scene.ngeom, scene.ngeom + COUNT)
        geoms.rows[added] = self._commands.rows[:COUNT]
        geoms.pos[added] += eye
        scene.ngeom += COUNT

    @cached_property
    def _commands(self) -> DrawnGeoms:
        """Return the geoms that `add` adds to a scene whose eye is at 0, and behind them the one of `number`."""
        scene = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), COUNT + 1)
        # MuJoCo draws a reflecting plane before all others. It is level and below the eye, so it is seen from above.
        first = _add(scene, mujoco.mjtGeom.mjGEOM_PLANE, self._start - self.drawing.basePlane - 1)
        first.pos[2], first.reflectance = -1.0, 1.0
        # Transparent geoms are drawn from near to far, without effect here, and then from far to near.
        before, behind = _BEFORE_PLANES
        for distance, commands in (
            (-_FAR, self._hide),
            (before, self._with_depth),
            (behind, self._without_depth),
            (_FAR, self._show),
        ):
            geom = _add(scene, mujoco.mjtGeom.mjGEOM_MESH, commands - self.drawing.baseMesh)
            geom.rgba[3] = 0.5
            if distance < 0:  # MuJoCo subtracts the size
                geom.size[:] = -distance
            else:
                geom.pos[0] = distance
        _add(scene, mujoco.mjtGeom.mjGEOM_MESH, 0)
        return DrawnGeoms(scene)

    def number(self, scene: mujoco.MjvScene, geoms: DrawnGeoms) -> None:
        """Have each pixel of the next image numbered by the geom that it shows: 1 for the first one.

        Args:
            scene: the scene, with at most `MOST_NUMBERS` geoms, and room for as many more; each becomes the second
                one of a pair.
            geoms: its geoms.
        """
        count = scene.ngeom
        while len(self._numbering) < count:
            self._numbering.append(self._list_of(functools.partial(self._number, len(self._numbering) + 1)))
        drawn = geoms.rows[:count].copy()
        geoms.rows[: 2 * count : 2] = self._commands.rows[COUNT]
        geoms.dataid[: 2 * count : 2] = np.array(self._numbering[:count]) - self.drawing.baseMesh
        geoms.rows[1 : 2 * count : 2] = drawn
        scene.ngeom = 2 * count

    def _number(self, number: int) -> None:
        gl = self._gl
        if number == 1:
            gl.glClearStencil(0)
            gl.glClear(gl.GL_STENCIL_BUFFER_BIT)
            gl.glEnable(gl.GL_STENCIL_TEST)
            gl.glStencilOp(gl.GL_KEEP, gl.GL_KEEP, gl.GL_REPLACE)
        gl.glStencilFunc(gl.GL_ALWAYS, number, MOST_NUMBERS)

    def read_numbers(self, height: int, width: int) -> NDArray[np.uint8]:
        """Return the numbers of the image that was drawn last, (height, width), its lowest row first."""
        numbers = np.empty((height, width), np.uint8)
        buffers, gl = self._framebuffers, self._gl
        buffers.glBindFramebuffer(buffers.GL_READ_FRAMEBUFFER, self.drawing.offFBO)
        gl.glPixelStorei(gl.GL_PACK_ALIGNMENT, 1)
        place = ctypes.c_void_p(numbers.ctypes.data)
        gl.glReadPixels(0, 0, width, height, gl.GL_STENCIL_INDEX, gl.GL_UNSIGNED_BYTE, place)
        return numbers

    def tint(self, geom: Any, color: NDArray[np.float64]) -> None:
        """Give a geom of a scene highlights of a colour, RGB 0..1; those of planes and capsules stay white."""
        kind = int(geom.type)
        if kind == _MESH and geom.dataid >= 0:
            drawn, size = self.drawing.baseMesh + geom.dataid, None
        elif kind in _SOLIDS and not self._has_texture(geom):
            drawn, size = self.drawing.baseBuiltin + _SOLIDS[kind], tuple(geom.size.tolist())
        else:
            return
        red, green, blue = color.tolist()
        wanted = (drawn, size, red, green, blue)
        made, number = self._tinted.get(geom.objid, (None, None))
        if made != wanted:
            gl = self._gl
            part = (ctypes.c_float * 4)(red, green, blue, 1.0)

            def draw() -> None:
                gl.glMaterialfv(gl.GL_FRONT_AND_BACK, gl.GL_SPECULAR, part)
                if size is not None:
                    gl.glScalef(*size)
                gl.glCallList(drawn)

            number = self._list_of(draw, number)
            self._tinted[geom.objid] = wanted, number
        assert number is not None
        geom.type, geom.dataid = _MESH, number - self.drawing.baseMesh

    def _has_texture(self, geom: Any) -> bool:
        return geom.matid >= 0 and self.drawing.mat_texid[_ROLES * geom.matid + _RGB] >= 0

    def end(self) -> None:
        """Show colours again, and end numbering, after a scene has been drawn."""
        self._gl.glColorMask(True, True, True, True)
        self._gl.glDisable(self._gl.GL_STENCIL_TEST)

    def _set_start(self, background: Color) -> None:
        """Fill the list that runs after MuJoCo has cleared the image and before it draws."""
        if background == self._background:
            return
        gl = self._gl

        def start() -> None:
            gl.glLightModeli(gl.GL_LIGHT_MODEL_LOCAL_VIEWER, 0)
            gl.glEnable(gl.GL_SCISSOR_TEST)  # MuJoCo has set it to the image
            gl.glClearColor(*background, 0.0)
            gl.glClear(gl.GL_COLOR_BUFFER_BIT)
            gl.glDisable(gl.GL_SCISSOR_TEST)

        self._list_of(start, self._start)
        self._background = background

    def free(self) -> None:
        """Free the context and its lists. A second call does nothing."""
        while self._numbers:
            self._gl.glDeleteLists(self._numbers.pop(), 1)
        self.drawing.free()

    def _list_of(self, commands: Callable[[], None], number: int | None = None) -> int:
        """Return the number of a display list of these commands; `number`: an older list, which they replace."""
        if number is None:
            number = self._unused()
        self._gl.glNewList(number, self._gl.GL_COMPILE)
        commands()
        self._gl.glEndList()
        return number

    def _unused(self) -> int:
        """Return a number that is not used: one that geoms can have, which count from MuJoCo's first list.

        Raises:
            mujoco.FatalError: OpenGL gives none; make a new renderer.
        """
        first = max(self.drawing.basePlane + 1, self.drawing.baseMesh)
        while number := int(self._gl.glGenLists(1)):
            self._numbers.append(number)
            if number >= first:
                return number
        raise mujoco.FatalError("OpenGL gives no display list; its context is lost")


def _add(scene: mujoco.MjvScene, kind: mujoco.mjtGeom, number: int) -> Any:
    """Add a geom that runs the list with this number, counted from MuJoCo's first one of its kind; return it."""
    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, np.ones(3), np.zeros(3), _NO_ROTATION, np.ones(4, np.float32))
    geom.dataid = number
    # MuJoCo leaves these as they were in memory; by the kind of object it decides how far away a geom is.
    geom.objtype, geom.objid = mujoco.mjtObj.mjOBJ_UNKNOWN, -1
    geom.category, geom.segid = mujoco.mjtCatBit.mjCAT_DECOR, -1
    scene.ngeom += 1
    return geom
