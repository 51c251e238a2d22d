"""Images with MuJoCo's OpenGL renderer: one context, no effects that V-REP lacked, RGB and depth in one rendering.

Shadows and multisampling cost ten to twenty times the image itself in software and V-REP's sensors had neither, so
both are off, as are reflections, fog and the skybox.

Light, transparency and background are V-REP's (see `commands`).

Each view has its own frustum with its own far plane, so OpenGL cuts colour and depth exactly where V-REP did, and
cleared pixels mean that nothing is seen.

Round geoms get half the corners where the difference is invisible (see `roundness`).
"""

from __future__ import annotations

import importlib
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.cameras.image import (
    DEPTH_OFFSET,
    NO_CODE,
    PART,
    CameraImage,
    CameraView,
    RenderError,
    nothing,
)
from simx_server.scene.cameras.visibility import (
    OPAQUE_ALPHA,
    SENSORS_GROUP,
    VISIBLE_GROUPS,
    drawn,
    near_the_view,
)
from simx_server.scene.geometry import lights
from simx_server.scene.geometry.highlights import highlights_of

from .backend import make_gl_context
from .commands import COUNT, MOST_NUMBERS, Commands
from .drawings import OFFSCREEN, drawing_of, have_one_drawing, textures_of
from .drawn_geoms import DrawnGeoms
from .roundness import may_be_coarse, round_geoms

logger = logging.getLogger(__name__)

_SHOWN = (
    mujoco.mjtVisFlag.mjVIS_TEXTURE,
    mujoco.mjtVisFlag.mjVIS_STATIC,
    mujoco.mjtVisFlag.mjVIS_SKIN,
    mujoco.mjtVisFlag.mjVIS_FLEXEDGE,
    mujoco.mjtVisFlag.mjVIS_FLEXSKIN,
)
_GEOM = int(mujoco.mjtObj.mjOBJ_GEOM)
_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
_LAST_GROUP = mujoco.mjNGROUP - 1
_NOTHING = int(mujoco.mjtGeom.mjGEOM_NONE)
_LARGE = 1 << 20
"""Pixels of an offscreen buffer that is freed while no images are requested; each pixel takes at least eight bytes."""

_FEWEST_CORNERS = 12
"""Minimum number of corners; with fewer, nothing looks round, however small."""

_CATEGORIES = int(mujoco.mjtCatBit.mjCAT_STATIC) | int(mujoco.mjtCatBit.mjCAT_DYNAMIC)


class OpenGLRenderer:
    """Renders one model at a time in one OpenGL context. Belongs to the thread that made it.

    Raises:
        RenderError: the context cannot be made.
    """

    def __init__(self, model: mujoco.MjModel, backend_name: str) -> None:
        self._closed = False
        self._option = _visible_things()
        self._camera = mujoco.MjvCamera()
        # Images are drawn into a separate offscreen buffer, so the context's own surface can be tiny.
        self._gl = make_gl_context(backend_name, 16, 16)
        try:
            self._gl.make_current()
            _offset_depth()
            self._take(model)
        except BaseException:
            self._gl.free()
            raise
        if self._fine.drawing.currentBuffer != OFFSCREEN:
            self.close()
            raise RenderError(f"the {backend_name} OpenGL driver offers no offscreen buffer")

    def turn_to(self, model: mujoco.MjModel) -> None:
        """Render another model from now on.

        Raises:
            mujoco.FatalError: OpenGL failed; make a new renderer.
        """
        self._gl.make_current()
        if not have_one_drawing(self._model, model):
            self._free_drawings()
            self._draw(model)
        self._look_at(model)

    def _take(self, model: mujoco.MjModel) -> None:
        self._draw(model)
        self._look_at(model)

    def _draw(self, model: mujoco.MjModel) -> None:
        self._fine = Commands(drawing_of(model))
        self._coarse: Commands | None = None
        self._textures = textures_of(model)

    def _look_at(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._round = round_geoms(model)
        self._highlights = highlights_of(model)
        most = model.ngeom + model.nskin + model.nflex + 16
        self._scene = mujoco.MjvScene(model, maxgeom=2 * most + COUNT)
        self._geoms = DrawnGeoms(self._scene)
        self._scene.flags[:] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_CULL_FACE] = 1

    def _upload_textures(self) -> None:
        """Upload the textures that materials have got since the context was made."""
        missing = textures_of(self._model) - self._textures
        for texture in missing:
            for commands in (self._fine, self._coarse):
                if commands is not None:
                    mujoco.mjr_uploadTexture(self._model, commands.drawing, texture)
        self._textures |= missing

    def render(
        self,
        data: mujoco.MjData,
        view: CameraView,
        rgb: bool,
        depth: bool,
        let_in: Callable[[], None] = nothing,
    ) -> CameraImage:
        """Return the image of `view` in the state `data` (forward kinematics done), with the requested channels.

        Args:
            data: the state.
            view: the camera view.
            rgb: whether to render colours.
            depth: whether to render depth.
            let_in: called between parts of the image; it may render other images.

        Raises:
            RenderError: the model does not have the camera.
            mujoco.FatalError: OpenGL failed; make a new renderer.
        """
        view.check_camera(self._model)
        is_flat = not rgb or view.codes is not None
        pixels = _Pixels.of(view, rgb=rgb, depth=depth or (rgb and is_flat))
        for rows in _parts(view, let_in):
            commands = self._compose(data, view, rows, is_flat=is_flat)
            self._fill(commands, view, pixels, rows)
        if pixels.colours is not None and is_flat:
            pixels.fill_background(view)
        return pixels.image(view, with_depth=depth)

    def render_both(
        self,
        data: mujoco.MjData,
        view: CameraView,
        coded: CameraView,
        let_in: Callable[[], None] = nothing,
    ) -> tuple[CameraImage, CameraImage]:
        """Return the image of `view`, and that of codes of the same place, each with both channels.

        Most pairs are drawn once: drawing numbers the geoms, and the numbers of the pixels give the codes.

        Args:
            data: the state (forward kinematics done).
            view: a view of colours.
            coded: a view of codes with the same `place`.
            let_in: called between parts of an image; it may render other images.

        Raises:
            RenderError: the model does not have the camera.
            mujoco.FatalError: OpenGL failed; make a new renderer.
        """
        import cv2  # the probe of a back end starts faster without it

        view.check_camera(self._model)
        pixels = _Pixels.of(view, rgb=True, depth=True)
        codes = np.empty((view.height, view.width, 3), np.uint8)
        coded_pixels = _Pixels(codes, pixels.nearness)
        for rows in _parts(view, let_in):
            commands = self._compose(data, view, rows, is_flat=False)
            if not self._can_be_numbered(data, view):
                image = self.render(data, view, True, True, let_in)
                return image, self.render(data, coded, True, True, let_in)
            colours_of_numbers = np.array([NO_CODE, *self._codes(coded.codes or ())], "<u4")
            commands.number(self._scene, self._geoms)
            self._fill(commands, view, pixels, rows)
            numbers = commands.read_numbers(rows.stop - rows.start, view.width)
            # Four bytes as one number, and then three of them, take a seventh of the time of rows of three bytes.
            found = colours_of_numbers[numbers].view(np.uint8).reshape(*numbers.shape, 4)
            cv2.cvtColor(found, cv2.COLOR_RGBA2RGB, codes[rows])
        coded_pixels.fill_background(coded)
        image = pixels.image(view, with_depth=True)
        return image, CameraImage(codes, image.depth)

    def _compose(self, data: mujoco.MjData, view: CameraView, rows: slice, *, is_flat: bool) -> Commands:
        """Fill the scene with what these rows of an image show; return what to draw it with.

        Args:
            data: the state.
            view: the camera view.
            rows: the rows.
            is_flat: whether the image lacks colours, so that light and textures are not needed: constant colours are
                much cheaper.
        """
        self._gl.make_current()
        self._upload_textures()
        near = near_the_view(self._model, data, view)
        has_others = view.is_users or bool(np.any(self._model.geom_group == SENSORS_GROUP))
        self._option.geomgroup[_LAST_GROUP] = has_others
        if self._option.geomgroup[_LAST_GROUP]:  # MuJoCo takes several groups for the last one
            near &= drawn(self._model, view)
        commands = self._commands_for(data, view, rows.stop - rows.start, near)
        self._take_scene(data, view, rows)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = is_flat
        self._scene.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = is_flat
        self._leave_out(data, view, near, is_flat)
        return commands

    def _fill(self, commands: Commands, view: CameraView, pixels: _Pixels, rows: slice) -> None:
        """Draw the scene, and read these rows of an image."""
        if view.codes is not None:
            # MuJoCo draws the number after it.
            self._geoms.segid[: self._scene.ngeom] = self._codes(view.codes) - 1
        if not self._scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT]:
            self._tint(commands)
            commands.add(self._scene, self._geoms, view.background)
        rect = mujoco.MjrRect(0, 0, view.width, rows.stop - rows.start)
        mujoco.mjr_render(rect, self._scene, commands.drawing)
        commands.end()
        mujoco.mjr_readPixels(
            None if pixels.colours is None else pixels.colours[rows],
            None if pixels.nearness is None else pixels.nearness[rows],
            rect,
            commands.drawing,
        )

    def rest(self) -> None:
        """Shrink large offscreen buffers; the next image enlarges them as needed."""
        self._gl.make_current()
        self._scene.ngeom = 0
        for commands in (self._fine, self._coarse):
            drawing = None if commands is None else commands.drawing
            if drawing is not None and drawing.offWidth * drawing.offHeight > _LARGE:
                mujoco.mjr_resizeOffscreen(1, 1, drawing)
                # A driver frees the old buffers when it has drawn to the new ones.
                mujoco.mjr_setBuffer(OFFSCREEN, drawing)
                mujoco.mjr_render(mujoco.MjrRect(0, 0, 1, 1), self._scene, drawing)
                mujoco.mjr_finish()

    def close(self) -> None:
        """Free the graphics driver's resources. A second call does nothing."""
        if self._closed:
            return
        self._closed = True
        self._gl.make_current()
        self._free_drawings()
        self._gl.free()

    def _free_drawings(self) -> None:
        for commands in (self._fine, self._coarse):
            if commands is not None:
                commands.free()

    def _commands_for(
        self, data: mujoco.MjData, view: CameraView, rows: int, near: NDArray[np.bool_]
    ) -> Commands:
        """Return what to draw this view with; its buffer is at least as large as the largest part so far."""
        quality, commands = self._model.vis.quality, self._fine
        corners = min(quality.numslices, 2 * quality.numstacks) // 2
        chosen = np.flatnonzero(near & self._round)
        if corners >= _FEWEST_CORNERS and may_be_coarse(self._model, data, view, chosen, corners):
            # Made on first use: it holds all meshes and textures a second time.
            commands = self._coarse = self._coarse or Commands(drawing_of(self._model, is_coarse=True))
        drawing = commands.drawing
        mujoco.mjr_setBuffer(OFFSCREEN, drawing)
        if view.width > drawing.offWidth or rows > drawing.offHeight:
            width, height = max(view.width, drawing.offWidth), max(rows, drawing.offHeight)
            mujoco.mjr_resizeOffscreen(width, height, drawing)
        return commands

    def _take_scene(self, data: mujoco.MjData, view: CameraView, rows: slice) -> None:
        if (stand := view.viewpoint) is None:
            self._camera.type, self._camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, view.camera_id
        else:
            self._camera.type, self._camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FREE, -1
            self._camera.lookat[:] = stand.lookat
            self._camera.distance = stand.distance
            self._camera.azimuth, self._camera.elevation = stand.azimuth_deg, stand.elevation_deg
        mujoco.mjv_updateScene(self._model, data, self._option, None, self._camera, _CATEGORIES, self._scene)
        lights.leave_out(self._scene, view.unlit)
        half_width, half_height = view.half_extent()
        at_near = 1.0 if view.orthographic_size is not None else view.near
        for eye in self._scene.camera:
            eye.orthographic = view.orthographic_size is not None
            eye.frustum_center = 0.0
            eye.frustum_width = half_width * at_near
            eye.frustum_top = (2 * rows.stop / view.height - 1) * half_height * at_near
            eye.frustum_bottom = (2 * rows.start / view.height - 1) * half_height * at_near
            eye.frustum_near = view.near
            eye.frustum_far = view.far

    def _leave_out(
        self, data: mujoco.MjData, view: CameraView, near: NDArray[np.bool_], is_flat: bool
    ) -> None:
        """Leave out geoms that need not be drawn.

        Geoms beside the view: their vertices cost as much as in the middle, and a hand camera has its robot behind
        it. Flat drawing makes everything solid, so planes that leave no depth in a coloured image are left out too.
        """
        scene, geoms = self._scene, self._geoms
        present = slice(scene.ngeom)
        is_geom = geoms.objtype[present] == _GEOM
        kept = is_geom if view.only is not None else np.ones(scene.ngeom, bool)
        kept[is_geom] = near[geoms.objid[present][is_geom]]
        if is_flat:
            kept &= ~self._backs(data, view)
        geoms.reflectance[present] = 0.0  # MuJoCo draws one reflecting geom before all others
        count = int(np.count_nonzero(kept))
        geoms.rows[:count] = geoms.rows[present][kept]
        scene.ngeom = count

    def _backs(self, data: mujoco.MjData, view: CameraView) -> NDArray[np.bool_]:
        """Return which geoms of the scene are planes seen from behind, which MuJoCo draws see-through."""
        present = slice(self._scene.ngeom)
        found = self._geoms.type[present] == _PLANE
        if found.any():
            towards = view.pose(data)[0] - self._geoms.pos[present]
            found &= np.einsum("gi,gi->g", towards, self._geoms.mat[present, :, 2]) < 0.0
        return found

    def _can_be_numbered(self, data: mujoco.MjData, view: CameraView) -> bool:
        """Return whether the scene's geoms are few, and opaque: others are drawn in the order of their distance."""
        count = self._scene.ngeom
        is_opaque = bool(np.all(self._geoms.rgba[:count, 3] >= OPAQUE_ALPHA))
        return count <= MOST_NUMBERS and is_opaque and not self._backs(data, view).any()

    def _codes(self, codes: tuple[int, ...]) -> NDArray[np.int32]:
        """Return the codes of the scene's geoms."""
        present = slice(self._scene.ngeom)
        is_geom = self._geoms.objtype[present] == _GEOM
        found = np.full(self._scene.ngeom, NO_CODE, np.int32)
        found[is_geom] = np.array(codes, np.int32)[self._geoms.objid[present][is_geom]]
        return found

    def _tint(self, commands: Commands) -> None:
        """Give the geoms whose material says so highlights of a colour."""
        if not self._highlights:
            return
        matid = self._model.geom_matid
        for geom in self._scene.geoms[: self._scene.ngeom]:
            if geom.objtype == _GEOM and geom.type != _NOTHING:
                color = self._highlights.get(int(matid[geom.objid]))
                if color is not None:
                    commands.tint(geom, color)


@dataclass
class _Pixels:
    """The channels of an image that is made in parts."""

    colours: NDArray[np.uint8] | None
    nearness: NDArray[np.float32] | None

    @classmethod
    def of(cls, view: CameraView, *, rgb: bool, depth: bool) -> _Pixels:
        shape = view.height, view.width
        return cls(
            np.empty((*shape, 3), np.uint8) if rgb else None, np.empty(shape, np.float32) if depth else None
        )

    def fill_background(self, view: CameraView) -> None:
        """Fill the pixels that show nothing, which MuJoCo makes black."""
        assert self.colours is not None
        assert self.nearness is not None
        background = np.array(view.background_bytes(), np.uint8)
        # Filling each pixel as one item is seven times as fast as three bytes.
        self.colours.view("V3")[..., 0][self.nearness == 0.0] = background.view("V3")

    def image(self, view: CameraView, *, with_depth: bool) -> CameraImage:
        if not with_depth or self.nearness is None:
            return CameraImage(self.colours, None)
        return CameraImage(self.colours, _linear_depth(self.nearness, view))


def _parts(view: CameraView, let_in: Callable[[], None]) -> Iterator[slice]:
    """Yield the rows of the parts of an image; call `let_in` between two parts."""
    rows_at_once = max(1, PART // view.width)
    for first in range(0, view.height, rows_at_once):
        if first:
            let_in()
        yield slice(first, min(first + rows_at_once, view.height))


def _visible_things() -> mujoco.MjvOption:
    """Return options for geoms of the visible groups, skins and flexes, without debugging aids."""
    option = mujoco.MjvOption()
    option.flags[:] = 0
    for flag in _SHOWN:
        option.flags[flag] = 1
    option.geomgroup[:] = 0
    option.geomgroup[list(VISIBLE_GROUPS)] = 1
    for decor in (option.sitegroup, option.jointgroup, option.tendongroup, option.actuatorgroup):
        decor[:] = 0
    return option


def _offset_depth() -> None:
    """Draw with V-REP's polygon offset from now on in the current context.

    MuJoCo changes this state only for shadows, which are off.
    """
    # Imported late, because a back end must choose PyOpenGL's platform before; OpenGL.GL loads a hundred more modules.
    gl = importlib.import_module("OpenGL.raw.GL.VERSION.GL_1_1")
    importlib.import_module("OpenGL.raw.GL.VERSION.GL_1_0").glEnable(gl.GL_POLYGON_OFFSET_FILL)
    # Negative, because MuJoCo's depth is 1 near and 0 far.
    gl.glPolygonOffset(-DEPTH_OFFSET, 0.0)


def _linear_depth(nearness: NDArray[np.float32], view: CameraView) -> NDArray[np.float32]:
    """Return depth 0..1 linear in distance, in place, from OpenGL's buffer that holds 1 near and 0 far.

    Perspective: the distance z = n f / (n + d (f - n)), so (z - n) / (f - n) = n (1 - d) / (n + d (f - n)).
    Orthographic: already linear.
    """
    if view.orthographic_size is not None:
        return np.subtract(1, nearness, out=nearness)
    divisor = nearness * np.float32(view.far - view.near)
    divisor += np.float32(view.near)
    np.subtract(1, nearness, out=nearness)
    nearness *= np.float32(view.near)
    nearness /= divisor
    return nearness
