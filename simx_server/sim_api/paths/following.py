"""Move an object along a path object: V-REP 3's motion, which waits."""

from __future__ import annotations

from simx_server.errors import CommandError
from simx_server.motion_profiles import State, line
from simx_server.scene.poses import frames
from simx_server.scripting.interpreter import Waiting
from simx_server.sim_api.motion.moving import Moving

_POSITION, _ORIENTATION = 1, 2


class PathFollowingFunctions(Moving):
    """Functions that return the unused seconds of the last simulation step."""

    def followPath(
        self,
        handle: int,
        path: int,
        what: int | None = None,
        start: float = 0.0,
        velocity: float = 1.0,
        acceleration: float = 0.0,
    ) -> Waiting:
        """Move an object along a path, from a share of its length, 0 to 1, to its end; with a negative velocity to its
        start. `what`: 1 position, 2 orientation, 3 or nil both. Metres and m/s are those of the path's method; an
        acceleration of 0 means unlimited.
        """
        own, other = self._self(handle), self._self(path)
        paths = self._world.paths
        length = paths.get(other).curve.length
        if velocity == 0:
            raise CommandError("with a velocity of 0 the object never arrives")
        chosen = 3 if what is None else what
        begin = min(max(start, 0.0), 1.0) * length
        way = length - begin if velocity > 0 else begin

        def put(state: State) -> bool:
            done = min(state.position[0], way)
            at = begin + done if velocity > 0 else begin - done
            # A closed path would go round at its very end, which is its start too.
            goal = paths.pose_at(other, at)
            now = frames.get_pose(self._sim, own)
            return self._put_pose(
                own,
                frames.WORLD,
                (
                    goal[0] if chosen & _POSITION else now[0],
                    goal[1] if chosen & _ORIENTATION else now[1],
                ),
            )

        if way <= 0:
            put(State([0.0], [0.0], [0.0]))
            return (0.0,)
        motion = yield from self._carry_out(line(way, abs(velocity), abs(acceleration)), put)
        return (motion.unused,)
