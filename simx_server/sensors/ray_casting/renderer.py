"""Images without OpenGL: MuJoCo's ray queries, one ray per pixel.

Slower than OpenGL except for small images, and simpler: no skins or flexes. It works wherever mujoco
does, and each depth is exact before V-REP's polygon offset. Where two surfaces meet, the nearer one is seen; the offset
of OpenGL moves such a line by up to half a pixel.
"""

from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.cameras.image import CameraImage, CameraView, nothing
from simx_server.scene.cameras.visibility import OPAQUE_ALPHA

from .rays import Rays, Seeing
from .surface import Surfaces

_LAYERS = 6
"""Maximum number of surfaces that a ray passes (see-through, or cut open by the near plane) before it is dropped."""
_RAYS_AT_ONCE = 40_000
"""Maximum number of rays per batch: limits the memory of a large image, and fits into the processor's cache."""


class RaycastRenderer:
    """Casts rays into one model at a time. Belongs to the thread that made it."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.turn_to(model)

    def turn_to(self, model: mujoco.MjModel) -> None:
        """Render another model from now on."""
        self._model = model
        self._surfaces = Surfaces(model)

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
            let_in: called between parts of the image.

        Raises:
            RenderError: the model does not have the camera.
        """
        view.check_camera(self._model)
        shape = (view.height, view.width)
        colours = np.empty((*shape, 3), np.uint8) if rgb else None
        depths = np.empty(shape, np.float32) if depth else None
        # One more, at the end, so that -1 (nothing hit) is an index even in an empty model.
        alpha = np.append(self._surfaces.rgba()[:, 3], np.float32(0))
        seeing = Seeing(self._model, data, view, alpha[:-1] > 0.0)
        shown = None
        if view.codes is not None:
            shown = _colours_of(view.codes)
            alpha[:] = 1.0
        rows_at_once = max(1, _RAYS_AT_ONCE // view.width)
        for first in range(0, view.height, rows_at_once):
            if first:
                let_in()
            rows = slice(first, min(first + rows_at_once, view.height))
            colour, distance = self._look(seeing, Rays.through_pixels(data, view, rows), alpha, rgb, shown)
            if colours is not None:
                colour *= 255.0
                colour += 0.5
                colours[rows] = colour.reshape(-1, view.width, 3)
            if depths is not None:
                linear = (distance - view.near) / (view.far - view.near)
                depths[rows] = linear.reshape(-1, view.width)
        return CameraImage(colours, depths)

    def render_both(
        self,
        data: mujoco.MjData,
        view: CameraView,
        coded: CameraView,
        let_in: Callable[[], None] = nothing,
    ) -> tuple[CameraImage, CameraImage]:
        """Return the images of a view of colours and of one of codes."""
        return self.render(data, view, True, True, let_in), self.render(data, coded, True, True, let_in)

    def rest(self) -> None:
        """Do nothing: no memory is held between two images."""

    def close(self) -> None:
        """Do nothing: no resources are held outside Python."""

    def _look(
        self,
        seeing: Seeing,
        rays: Rays,
        alpha: NDArray[np.float32],
        rgb: bool,
        shown: NDArray[np.float32] | None,
    ) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """Return colour (n, 3) 0..1 and depth in metres (n,) at the end of each ray, `far` where nothing is.

        `shown`: (ngeom, 3), colours that replace the geoms' own colours and light; None: their normal appearance.
        """
        view = seeing.view
        count = len(rays.directions)
        colour = np.zeros((count, 3), np.float32)
        distance = np.full(count, view.far, np.float64)
        unblocked = np.ones(count, np.float32)
        unmeasured = np.ones(count, bool)

        todo: list[tuple[NDArray[np.intp], tuple[int, ...]]] = [(np.arange(count), ())]
        while todo:
            pixels, passed = todo.pop()
            some = rays.of(pixels)
            geom_ids, depths, normals = seeing.nearest(some, passed)
            hit = (geom_ids >= 0) & (depths <= view.far)
            facing = np.einsum("ij,ij->i", normals, some.directions) < 0.0
            seen = hit & facing & (depths >= view.near)
            solid = seen & (alpha[geom_ids] >= OPAQUE_ALPHA)
            first = np.flatnonzero(seen & unmeasured[pixels])
            distance[pixels[first]] = seeing.drawn_depths(some.of(first), depths[first], normals[first])
            unmeasured[pixels[first]] = False
            if rgb and seen.any():
                lit = np.flatnonzero(seen)
                where, geoms = pixels[lit], geom_ids[lit]
                if shown is not None:
                    shades = shown[geoms]
                else:
                    points = some.of(lit).at(depths[lit])
                    shades = self._surfaces.colours(
                        seeing.data, geoms, points, normals[lit], rays.forward, view.unlit
                    )
                cover = np.where(solid[lit], np.float32(1), alpha[geoms])
                colour[where] += (unblocked[where] * cover)[:, np.newaxis] * shades
                unblocked[where] *= 1.0 - cover
            further = hit & ~solid
            if further.any() and len(passed) < _LAYERS:
                for geom_id in np.unique(geom_ids[further]):
                    todo.append((pixels[further & (geom_ids == geom_id)], (*passed, int(geom_id))))
        if rgb and any(view.background):
            colour += unblocked[:, np.newaxis] * np.clip(view.background, 0.0, 1.0).astype(np.float32)
        return colour, distance


def _colours_of(codes: tuple[int, ...]) -> NDArray[np.float32]:
    """Return (ngeom, 3) RGB 0..1 whose bytes are the three bytes of the codes, the lowest first."""
    parts = np.array(codes, "<u4").view(np.uint8).reshape(-1, 4)
    return parts[:, :3].astype(np.float32) / np.float32(255)
