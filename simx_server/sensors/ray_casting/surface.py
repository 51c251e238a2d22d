"""The appearance of a surface to a cast ray: its colour and the light on it.

Follows the OpenGL renderer, that is fixed-function lighting with an eye far away. Emission plus, for every light,
ambient plus diffuse times the cosine of the angle of incidence, times the colour; plus the highlight of every light,
specular light times specular colour times a power of the cosine between the surface's normal and the half-way vector
of the directions to light and eye. All that times the texture: a plane shows its texture; other geoms show the mean
colour of theirs.
"""

import math
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.highlights import highlights_of
from simx_server.scene.geometry.lights import leave_out

Points = NDArray[np.float64]
"""(n, 3) in the world frame: metres or unit vectors."""
Ids = NDArray[np.int32]
"""(n,) MuJoCo geom ids."""

_MOST_LIGHTS = 8
"""Lights that OpenGL applies, the headlight among them; MuJoCo leaves out the rest."""

_WITHOUT_LIGHTS = 0.3
"""Ambient light that MuJoCo's renderer assumes for a scene without lights."""
_WITHOUT_MATERIAL = (0.5, 0.5, 0.0)
"""Specular part, shininess and emission that MuJoCo's renderer gives a geom without a material."""

_UNSET_RGBA = np.array([0.5, 0.5, 0.5, 1.0], np.float32)
"""A geom's default colour, which the material's colour overrides."""


class Surfaces:
    """Colours of one model's geoms under its lights, read again for each image because colours may change."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._tinted = highlights_of(model)
        self._scene = mujoco.MjvScene(model, maxgeom=1)
        for eye in self._scene.camera:
            # Only so that mjv_makeLights accepts the scene; the headlight is aimed later.
            eye.frustum_near, eye.forward, eye.up = 1.0, (0, 0, -1), (0, 1, 0)
        self._textures = [_texels(model, texid) for texid in range(model.ntex)]
        self._mean_colours = [texels.mean(axis=(0, 1)) for texels in self._textures]

    def rgba(self) -> NDArray[np.float32]:
        """Return (ngeom, 4): each geom's colour, its own or else its material's, before texture."""
        model = self._model
        rgba = np.array(model.geom_rgba)
        by_material = (model.geom_matid >= 0) & np.all(rgba == _UNSET_RGBA, axis=1)
        rgba[by_material] = model.mat_rgba[model.geom_matid[by_material]]
        return rgba

    def colours(
        self,
        data: mujoco.MjData,
        geom_ids: Ids,
        points: Points,
        normals: Points,
        forward: NDArray[np.float64],
        unlit: int = 0,
    ) -> NDArray[np.float32]:
        """Return (n, 3) RGB 0..1 of points on geoms, seen by a camera that looks along `forward`.

        `unlit`: see `CameraView.unlit`.
        """
        mujoco.mjv_makeLights(self._model, data, self._scene)
        leave_out(self._scene, unlit)
        lights = self._scene.lights[: min(self._scene.nlight, _MOST_LIGHTS)]
        specular, shininess, emission = self._finish()
        colours = _light(lights, points, normals, forward)
        if emission.any():
            colours += emission[geom_ids, np.newaxis]
        colours *= self.rgba()[geom_ids, :3]
        shines = np.flatnonzero(specular[geom_ids] > 0.0)
        if len(shines):
            exponents = 128.0 * shininess[geom_ids[shines]]
            highlights = _highlights(lights, points[shines], normals[shines], forward, exponents)
            colours[shines] += self._highlight_colours(specular)[geom_ids[shines]] * highlights
        np.minimum(colours, 1.0, out=colours)
        self._apply_textures(data, geom_ids, points, colours)
        return colours

    def _finish(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Return (ngeom,) each: specular part, shininess and emission of the geoms, 0..1."""
        model = self._model
        finish = np.stack((model.mat_specular, model.mat_shininess, model.mat_emission))
        # The last column is that of geoms without a material, whose number is -1.
        finish = np.column_stack((finish, _WITHOUT_MATERIAL)).astype(np.float32)
        specular, shininess, emission = finish[:, model.geom_matid]
        return specular, shininess, emission

    def _highlight_colours(self, specular: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (ngeom, 3): the colours of highlights, whose strengths are `specular`."""
        colours = np.repeat(specular[:, np.newaxis], 3, axis=1)
        for material, color in self._tinted.items():
            colours[self._model.geom_matid == material] = color
        return colours

    def _apply_textures(
        self, data: mujoco.MjData, geom_ids: Ids, points: Points, colours: NDArray[np.float32]
    ) -> None:
        model = self._model
        if not model.ntex or not model.nmat:
            return
        role = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)
        texid_of_geom = np.where(
            model.geom_matid >= 0, model.mat_texid[np.maximum(model.geom_matid, 0), role], -1
        )
        for geom_id in np.flatnonzero(texid_of_geom >= 0):
            here = np.flatnonzero(geom_ids == geom_id)
            if not len(here):
                continue
            texid = int(texid_of_geom[geom_id])
            is_plane = model.geom_type[geom_id] == mujoco.mjtGeom.mjGEOM_PLANE.value
            if is_plane and model.tex_type[texid] == mujoco.mjtTexture.mjTEXTURE_2D.value:
                frame = data.geom_xmat[geom_id].reshape(3, 3)
                local = points[here] @ frame[:, :2] - data.geom_xpos[geom_id] @ frame[:, :2]
                colours[here] *= self._look_up(int(geom_id), texid, local)
            else:
                colours[here] *= self._mean_colours[texid]

    def _look_up(self, geom_id: int, texid: int, local: Points) -> NDArray[np.float32]:
        """Return (n, 3): nearest texels at points (n, 2) in a plane's frame.

        Found by comparing with MuJoCo 4.0's OpenGL images: the texture repeats from the plane's upper left corner;
        on an infinite plane a copy is centred on the origin.
        """
        model = self._model
        matid = model.geom_matid[geom_id]
        size = model.geom_size[geom_id, :2]
        per_metre = np.array(model.mat_texrepeat[matid], np.float64)
        offset = np.full(2, 0.5)
        if np.all(size > 0):
            per_metre /= 1.0 if model.mat_texuniform[matid] else size
            offset = 0.5 * per_metre * size
        texels = self._textures[texid]
        rows: int
        columns: int
        rows, columns = texels.shape[:2]
        column = _repeated(0.5 * per_metre[0] * local[:, 0] + offset[0], columns)
        row = _repeated(-0.5 * per_metre[1] * local[:, 1] + offset[1], rows)
        row *= columns
        row += column
        return texels.reshape(-1, 3).take(row, axis=0)


def _repeated(place: NDArray[np.float64], count: int) -> NDArray[np.intp]:
    """Return the texel, 0 .. count - 1, at positions measured in whole textures."""
    place -= np.floor(place)
    place *= count
    return np.minimum(place.astype(np.intp), count - 1)


def _is_parallel(light: mujoco.MjvLight) -> bool:
    return bool(light.headlight) or light.type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL


def _light(
    lights: Sequence[mujoco.MjvLight], points: Points, normals: Points, forward: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return (n, 3): ambient and diffuse light that reaches each point."""
    parallel = [light for light in lights if _is_parallel(light)]
    ambient = sum((light.ambient for light in parallel), np.zeros(3, np.float32))
    total = np.empty(points.shape, np.float32)
    total[:] = ambient if lights else _WITHOUT_LIGHTS
    shining = [light for light in parallel if light.diffuse.any()]
    if shining:
        towards = -np.stack([forward if light.headlight else light.dir for light in shining])
        incidence = normals.astype(np.float32) @ towards.T.astype(np.float32)
        np.maximum(incidence, 0.0, out=incidence)
        total += incidence @ np.stack([light.diffuse for light in shining])
    for light in lights:
        if not _is_parallel(light):
            towards, strength = _from_a_point(light, points)
            incidence = np.maximum(np.einsum("ij,ij->i", normals, towards), 0.0)
            total += strength[:, np.newaxis] * (light.ambient + incidence[:, np.newaxis] * light.diffuse)
    return total


def _highlights(
    lights: Sequence[mujoco.MjvLight],
    points: Points,
    normals: Points,
    forward: NDArray[np.float64],
    exponents: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return (n, 3): light that each point reflects as a mirror with a specular colour of 1 would."""
    total = np.zeros(points.shape, np.float32)
    for light in lights:
        if not np.any(light.specular):
            continue
        if _is_parallel(light):
            towards = -np.broadcast_to(forward if light.headlight else light.dir, points.shape)
            strength = np.ones(len(points))
        else:
            towards, strength = _from_a_point(light, points)
        halfway = towards - forward
        halfway /= np.maximum(np.linalg.norm(halfway, axis=1), 1e-9)[:, np.newaxis]
        cosine = np.maximum(np.einsum("ij,ij->i", normals, halfway), 0.0)
        is_lit = np.einsum("ij,ij->i", normals, towards) > 0.0
        total += (is_lit * strength * cosine**exponents)[:, np.newaxis] * light.specular
    return total


def _from_a_point(light: mujoco.MjvLight, points: Points) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the directions (n, 3) to a lamp with a position, and its strength (n,) at points.

    It is weaker with distance and, for a spot, outside its cone.
    """
    towards = light.pos - points
    distance = np.linalg.norm(towards, axis=1)
    towards /= np.maximum(distance, 1e-9)[:, np.newaxis]
    constant, linear, quadratic = (float(factor) for factor in light.attenuation)
    strength = 1.0 / np.maximum(constant + linear * distance + quadratic * distance**2, 1e-9)
    if light.type == mujoco.mjtLightType.mjLIGHT_SPOT and light.cutoff < 180.0:
        cosine = np.maximum(towards @ -np.asarray(light.dir, np.float64), 0.0)
        strength *= np.where(cosine > math.cos(math.radians(light.cutoff)), cosine**light.exponent, 0.0)
    return towards, strength


def _texels(model: mujoco.MjModel, texid: int) -> NDArray[np.float32]:
    """Return (rows, columns, 3) 0..1 of one texture; a cube's six faces lie below each other."""
    rows, columns, channels = (
        int(model.tex_height[texid]),
        int(model.tex_width[texid]),
        int(model.tex_nchannel[texid]),
    )
    start = int(model.tex_adr[texid])
    texels = model.tex_data[start : start + rows * columns * channels].reshape(rows, columns, channels)
    return np.ascontiguousarray(np.broadcast_to(texels[..., :3] / np.float32(255), (rows, columns, 3)))
