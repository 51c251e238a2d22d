"""Create path objects: curves of V-REP 3, paths of CoppeliaSim 4 with their points as data, and meshes along paths."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import mujoco

from simx_client.protocol import constants as c
from simx_server.editing import creating
from simx_server.editing.creating import Body
from simx_server.editing.grafts.grafting import Graft, graft
from simx_server.errors import CommandError
from simx_server.parts.paths import along
from simx_server.parts.paths.flat_paths import MOST_NUMBERS
from simx_server.parts.paths.paths import Track
from simx_server.scene.formats.loader import prepare
from simx_server.scene.geometry.curve import LENGTH_PER_ANGLE, Curve, Method, Rules
from simx_server.scene.geometry.sweep import sweep
from simx_server.scene.poses.poses import Pose
from simx_server.scripting.conversion.signature import Most
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.values.matrices import vector
from simx_server.sim_api.values.packing import pack, pack_table

if TYPE_CHECKING:
    from simx_server.scene.formats.annotations import Annotation

_DEFAULTS = (
    c.sim_pathproperty_automatic_orientation
    | c.sim_pathproperty_show_line
    | c.sim_pathproperty_infinite_acceleration
)
"""Attributes of a new path of V-REP 3, with -1."""

_CLOSED, _TURNED = 2, 16
"""Bits of the options of CoppeliaSim 4's sim.createPath."""

_MESH_CLOSED = 4
"""Bit of the options of sim.generateShapeFromPath."""

_LINE_COLOR = (0.0, 0.96, 0.66)
_UP = (0.0, 0.0, 1.0)
_Numbers = Annotated[list[float], Most(MOST_NUMBERS)]
_MOST_SUBDIVISIONS = 4000
_MOST_CONTROL_POINTS = 1500
"""Each becomes a dummy, and 40 points of the curve."""


class PathMakingFunctions(ApiPart, effect="changes"):
    """Functions that create objects; those created during a run are removed at its stop."""

    def createPath(
        self,
        attributes_or_points: int | list[float],
        options: int | list[int] | None = None,
        subdivisions: int | list[float] | None = None,
        smoothness: float | list[float] | None = None,
        orientation: int = 0,
        up: list[float] | None = None,
    ) -> int:
        """Create a path at the origin. V-REP 3: attributes (sim.pathproperty_*, or -1), then {line size, method of
        lengths}, {size, metres per radian}; control points come with sim.insertPathCtrlPoints. CoppeliaSim 4: poses of
        control points; options 2 closed, 16 oriented along the way; number of points (100); smoothness 0 to 1 (1);
        orientation mode; vector upwards.

        Partly: sizes and colours are ignored, and so are the options that show or hide it. In CoppeliaSim 4's form the
        points do not follow control points that are moved later.
        """
        if isinstance(attributes_or_points, list):
            return self._path_of_poses(
                attributes_or_points,
                options if isinstance(options, int) else 0,
                subdivisions if isinstance(subdivisions, int) else 100,
                float(smoothness) if isinstance(smoothness, (int, float)) else 1.0,
                orientation,
                _UP if up is None else vector(up, "a vector upwards"),
            )
        counts = options if isinstance(options, list) else []
        sizes = subdivisions if isinstance(subdivisions, list) else []
        return self._path_object(attributes_or_points, counts, sizes)

    def generateShapeFromPath(
        self, path: _Numbers, section: _Numbers, options: int = 0, up: list[float] | None = None
    ) -> int:
        """Create a shape along a path of poses in the world: x, y, z and a quaternion x, y, z, w each.

        `section`: x across the way and y upwards of each point; when the last one is the first one, the shape is
        solid. Options: 4 the path is closed. `up`: {0, 0, 1} if nil; with {0, 0, 0} the section lies in the x-y planes
        of the poses.
        """
        poses = along.poses_of(path)
        if not section or len(section) % 2:
            raise CommandError(f"a section is x and y of each point, not {len(section)} numbers")
        is_closed = bool(options & _MESH_CLOSED)
        if is_closed and along.has_overlapping_ends(poses):
            poses = poses[:-1]
        upwards = _UP if up is None else vector(up, "a vector upwards")
        if any(upwards):
            ring = [*poses, poses[0]] if is_closed else poses
            # The section's x points to the right of somebody who looks along the way.
            turned = along.oriented(ring, 5, upwards, is_closed=is_closed)
            poses = turned[: len(poses)]
        points, faces = sweep(poses, list(zip(section[::2], section[1::2], strict=True)), is_closed=is_closed)
        return creating.create_mesh(self._world, points, faces, "Shape", Body())

    def _path_object(self, attributes: int, counts: list[int], sizes: list[float]) -> int:
        bits = _DEFAULTS if attributes == -1 else attributes
        method = counts[1] if len(counts) > 1 else int(Method.DISTANCE_OR_ANGLE)
        if method not in set(Method):
            raise CommandError(
                f"{method} is no method of lengths; those are {min(Method):d} to {max(Method):d}"
            )
        rules = Rules(
            is_closed=bool(bits & c.sim_pathproperty_closed_path),
            method=Method(method),
            angle_to_length=sizes[1] if len(sizes) > 1 and sizes[1] > 0 else LENGTH_PER_ANGLE,
            follows_curve=bool(bits & c.sim_pathproperty_automatic_orientation),
            keeps_x_up=bool(bits & c.sim_pathproperty_keep_x_up),
            is_flat=bool(bits & c.sim_pathproperty_flat_path),
        )

        def build(spec: mujoco.MjSpec, name: str) -> None:
            spec.worldbody.add_site(name=name, group=4)

        handle = creating.add(self._world, "Path", "site", build, {"object": {"type": "path"}})
        self._world.paths.define(handle, Track(Curve([], rules)))
        return handle

    def _path_of_poses(
        self,
        numbers: list[float],
        options: int,
        subdivisions: int,
        smoothness: float,
        orientation: int,
        up: tuple[float, float, float],
    ) -> int:
        if not 2 <= subdivisions <= _MOST_SUBDIVISIONS:
            raise CommandError(f"a path has 2 to {_MOST_SUBDIVISIONS} points, not {subdivisions}")
        control = along.poses_of(numbers)
        if len(control) > _MOST_CONTROL_POINTS:
            raise CommandError(
                f"a path has at most {_MOST_CONTROL_POINTS} control points, not {len(control)}"
            )
        is_closed = bool(options & _CLOSED)
        points = along.interpolated(control, subdivisions, min(smoothness, 1.0), is_closed=is_closed)
        if options & _TURNED:
            points = along.oriented(points, orientation, up, is_closed=is_closed)
        handle = self._dummies(control)
        data = self._world.custom_data
        data.write(handle, "PATHCTRLPTS", pack("d", along.numbers_of(control), 0, 0))
        data.write(handle, "PATH", pack("d", along.numbers_of(points), 0, 0))
        info: dict[str, Any] = {
            "autoOrientation": orientation,
            "bitCoded": options,
            "ctrlPtFixedSize": False,
            "line": {"color": list(_LINE_COLOR), "thickness": 3},
            "pointCnt": subdivisions,
            "smoothing": smoothness,
            "upVector": list(up),
        }
        data.write(handle, "ABC_PATH_INFO", pack_table(info))
        return handle

    def _dummies(self, control: list[Pose]) -> int:
        """Create the dummy of a path, with a dummy below it for each control point; return its handle."""
        names: dict[tuple[str, str], str] = {("site", "Path"): "Path"}
        notes: dict[str, dict[str, Annotation]] = {}
        spec = mujoco.MjSpec()
        spec.worldbody.add_site(name="Path", group=4)
        for index, (place, turn) in enumerate(control):
            name = f"Path_ctrlPt{index}"
            spec.worldbody.add_site(name=name, group=4, pos=list(place), quat=list(turn))
            names["site", name] = name
            notes[name] = {"object": {"alias": "ctrlPt"}}
        prepare(spec)
        handles = graft(self._sim, Graft(spec, names, notes))
        path = handles["site", "Path"]
        points = [handles["site", f"Path_ctrlPt{index}"] for index in range(len(control))]
        self._sim.scene.override_parents(dict.fromkeys(points, path))
        for index, handle in enumerate(points, 1):
            own = pack_table({"handle": handle, "index": index})
            self._world.custom_data.write(handle, "ABC_PATHCTRLPT", own)
        self._sim.changed()
        return path
