"""Arithmetic with matrices, poses and angles for scripts.

A matrix is 12 numbers, three rows of rotation and position (metres); a pose is 7: x, y, z, then a quaternion x, y, z,
w. Euler angles are radians with R = Rx(alpha) Ry(beta) Rz(gamma).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from simx_server.errors import CommandError
from simx_server.scene.poses import frames, poses
from simx_server.scene.poses.poses import IDENTITY, Pose
from simx_server.sim_api.base import ApiPart

_MATRIX, _POSE = 12, 7


def as_pose(values: Sequence[float]) -> Pose:
    """Return seven numbers as a pose.

    Raises:
        CommandError: there are more or fewer numbers.
    """
    if len(values) < _POSE:
        raise CommandError(f"a pose is 7 numbers, x y z and a quaternion x y z w, not {len(values)}")
    x, y, z = vector(values[:3], "a position")
    return (x, y, z), frames.wxyz_from_xyzw(values[3:_POSE])


def as_numbers(pose: Pose) -> list[float]:
    """Return a pose as seven numbers, the quaternion's w not negative."""
    return [*pose[0], *frames.xyzw_from_wxyz(pose[1])]


def vector(values: Sequence[float], what: str = "a vector") -> poses.Vector:
    """Return three numbers as a vector.

    Raises:
        CommandError: there are more or fewer numbers.
    """
    if len(values) < 3:
        raise CommandError(f"{what} is 3 numbers, not {len(values)}")
    return float(values[0]), float(values[1]), float(values[2])


def _either(values: Sequence[float]) -> tuple[Pose, bool]:
    """Return the pose of a matrix or a pose, and whether it was a matrix."""
    if len(values) >= _MATRIX:
        return frames.pose_from_matrix12(values), True
    if len(values) >= _POSE:
        return as_pose(values), False
    raise CommandError(f"a matrix has 12 numbers and a pose 7, but this has {len(values)}")


def _unit(values: Sequence[float], what: str) -> poses.Vector:
    axis = vector(values, what)
    length = math.sqrt(sum(component * component for component in axis))
    if length < 1e-12:
        raise CommandError(f"{what} must not be of length 0")
    return poses.scale(axis, 1 / length)


class MatrixFunctions(ApiPart, effect="reads"):
    """Functions for matrices. They do not access the scene."""

    def buildIdentityMatrix(self) -> list[float]:
        return frames.matrix12(IDENTITY)

    def copyMatrix(self, matrix: list[float]) -> list[float]:
        frames.pose_from_matrix12(matrix)  # it must be one
        return matrix

    def buildMatrix(self, position: list[float], euler: list[float]) -> list[float]:
        return frames.matrix12(
            (vector(position, "a position"), frames.quat_from_euler(vector(euler, "an orientation")))
        )

    def buildMatrixQ(self, position: list[float], quaternion: list[float]) -> list[float]:
        return frames.matrix12((vector(position, "a position"), frames.wxyz_from_xyzw(quaternion)))

    def buildPose(
        self, position: list[float], rotation: list[float], mode: int = 0, axis: list[float] | None = None
    ) -> list[float]:
        """Return a pose. Mode 0: `rotation` is Euler angles or a quaternion. 1, 2, 3: it is the x, y or z axis of the
        new frame.

        4 to 9: `rotation` and `axis` are two axes: xy, yz, zx, xz, yx, zy; the second one is made perpendicular to
        the first.
        """
        place = vector(position, "a position")
        if mode == 0 and len(rotation) == 4:
            return as_numbers((place, frames.wxyz_from_xyzw(rotation)))
        if mode == 0:
            return as_numbers((place, frames.quat_from_euler(vector(rotation, "an orientation"))))
        return as_numbers((place, _from_axes(mode, rotation, axis)))

    def poseToMatrix(self, pose: list[float]) -> list[float]:
        return frames.matrix12(as_pose(pose))

    def matrixToPose(self, matrix: list[float]) -> list[float]:
        return as_numbers(frames.pose_from_matrix12(matrix))

    def multiplyMatrices(self, first: list[float], second: list[float]) -> list[float]:
        return frames.matrix12(
            poses.compose(frames.pose_from_matrix12(first), frames.pose_from_matrix12(second))
        )

    def multiplyPoses(self, first: list[float], second: list[float]) -> list[float]:
        return as_numbers(poses.compose(as_pose(first), as_pose(second)))

    def invertMatrix(self, matrix: list[float]) -> list[float]:
        """Invert a matrix. A Lua table is overwritten with its inverse, and the result is 1, as in V-REP; Python gets
        the inverse.
        """
        return self.getMatrixInverse(matrix)

    def getMatrixInverse(self, matrix: list[float]) -> list[float]:
        return frames.matrix12(poses.inverse(frames.pose_from_matrix12(matrix)))

    getInvertedMatrix = getMatrixInverse

    def invertPose(self, pose: list[float]) -> list[float]:
        return as_numbers(poses.inverse(as_pose(pose)))

    getPoseInverse = invertPose

    def getQuaternionInverse(self, quaternion: list[float]) -> list[float]:
        """Return the opposite rotation, x, y, z, w."""
        if len(quaternion) < 4:
            raise CommandError(f"a quaternion is 4 numbers, not {len(quaternion)}")
        x, y, z, w = quaternion[:4]
        return [-x, -y, -z, w]

    def multiplyVector(self, frame: list[float], points: list[float]) -> list[float]:
        """Apply a matrix or pose to one point, or to several in one table."""
        pose, _ = _either(frame)
        if len(points) < 3:
            raise CommandError(f"a point is 3 numbers, not {len(points)}")
        (px, py, pz), quat = pose
        found: list[float] = []
        # Further numbers are ignored, such as the 1 of {x, y, z, 1}.
        for x, y, z in zip(points[::3], points[1::3], points[2::3], strict=False):
            x, y, z = poses.rotate(quat, (x, y, z))
            found += px + x, py + y, pz + z
        return found

    def getEulerAnglesFromMatrix(self, matrix: list[float]) -> list[float]:
        return frames.euler_from_quat(frames.pose_from_matrix12(matrix)[1])

    def getQuaternionFromMatrix(self, matrix: list[float]) -> list[float]:
        return frames.xyzw_from_wxyz(frames.pose_from_matrix12(matrix)[1])

    def interpolateMatrices(self, first: list[float], second: list[float], share: float) -> list[float]:
        """Return a matrix between the two: share 0 is the first, 1 the second; positions on a line, rotations on the
        shorter way.
        """
        return frames.matrix12(
            _between(frames.pose_from_matrix12(first), frames.pose_from_matrix12(second), share)
        )

    def interpolatePoses(self, first: list[float], second: list[float], share: float) -> list[float]:
        return as_numbers(_between(as_pose(first), as_pose(second), share))

    def getRotationAxis(self, start: list[float], goal: list[float]) -> tuple[list[float], float]:
        """Return axis (in the frame of both matrices) and angle of the rotation from one to the other."""
        turn = poses.multiply(_either(goal)[0][1], poses.conjugate(_either(start)[0][1]))
        rotation = poses.rotation_vector(turn)
        angle = math.sqrt(sum(component * component for component in rotation))
        if angle < 1e-12:
            return [0.0, 0.0, 1.0], 0.0
        return list(poses.scale(rotation, 1 / angle)), angle

    def rotateAroundAxis(
        self, frame: list[float], axis: list[float], point: list[float], angle: float
    ) -> list[float]:
        """Rotate a matrix or pose by radians about an axis through a point; the result is of the same kind."""
        pose, is_matrix = _either(frame)
        centre = vector(point, "a point of the axis")
        turn = poses.about(_unit(axis, "an axis"), angle)
        place = poses.add(centre, poses.rotate(turn, poses.subtract(pose[0], centre)))
        turned = place, poses.multiply(turn, pose[1])
        return frames.matrix12(turned) if is_matrix else as_numbers(turned)

    def alphaBetaGammaToYawPitchRoll(
        self, alpha: float, beta: float, gamma: float
    ) -> tuple[float, float, float]:
        """Return yaw, pitch, roll with R = Rz(yaw) Ry(pitch) Rx(roll)."""
        rows = poses.matrix(frames.quat_from_euler([alpha, beta, gamma]))
        sine = max(-1.0, min(1.0, rows[2][0]))
        if (
            abs(sine) < 0.999999
        ):  # V-REP's limit; beyond it yaw and roll rotate about one axis, and roll is set to 0
            yaw, roll = math.atan2(rows[1][0], rows[0][0]), math.atan2(rows[2][1], rows[2][2])
        else:
            yaw, roll = math.atan2(-rows[0][1], rows[1][1]), 0.0
        return yaw, math.asin(-sine), roll

    def yawPitchRollToAlphaBetaGamma(
        self, yaw: float, pitch: float, roll: float
    ) -> tuple[float, float, float]:
        about_x = poses.about((1.0, 0.0, 0.0), roll)
        about_y = poses.about((0.0, 1.0, 0.0), pitch)
        about_z = poses.about((0.0, 0.0, 1.0), yaw)
        quat = poses.multiply(poses.multiply(about_z, about_y), about_x)
        alpha, beta, gamma = frames.euler_from_quat(quat)
        return alpha, beta, gamma

    def abgToYpr(self, angles: list[float]) -> list[float]:
        """Return {yaw, pitch, roll} of {alpha, beta, gamma}."""
        return list(self.alphaBetaGammaToYawPitchRoll(*vector(angles, "angles")))

    def yprToAbg(self, angles: list[float]) -> list[float]:
        """Return {alpha, beta, gamma} of {yaw, pitch, roll}."""
        return list(self.yawPitchRollToAlphaBetaGamma(*vector(angles, "angles")))


def _between(first: Pose, second: Pose, share: float) -> Pose:
    way = poses.subtract(second[0], first[0])
    return poses.add(first[0], poses.scale(way, share)), poses.blend(first[1], second[1], share)


_AXIS_PAIRS = {4: (0, 1), 5: (1, 2), 6: (2, 0), 7: (0, 2), 8: (1, 0), 9: (2, 1)}
"""Modes of buildPose and the axes passed: 0 x, 1 y, 2 z."""


def _from_axes(mode: int, first: Sequence[float], second: Sequence[float] | None) -> poses.Quaternion:
    if not 1 <= mode <= 9:
        raise CommandError(f"the mode of a pose is 0 to 9, not {mode}")
    a, b = _AXIS_PAIRS.get(mode, ((mode - 1), mode % 3))
    known = _unit(first, "an axis")
    if mode in _AXIS_PAIRS:
        if second is None:
            raise CommandError(f"mode {mode} needs two axes")
        other = _unit(second, "the second axis")
    else:  # any perpendicular direction is valid; the frame's axis is used where it is not parallel to the axis
        other = (0.0, 0.0, 1.0) if abs(known[2]) < 0.9 else (1.0, 0.0, 0.0)
    along = sum(x * y for x, y in zip(known, other, strict=True))
    other = _unit(
        poses.subtract(other, poses.scale(known, along)), "the part of the second axis across the first"
    )
    third = 3 - a - b
    sign = 1.0 if (a + 1) % 3 == b else -1.0
    cross = (
        known[1] * other[2] - known[2] * other[1],
        known[2] * other[0] - known[0] * other[2],
        known[0] * other[1] - known[1] * other[0],
    )
    columns = {a: known, b: other, third: poses.scale(cross, sign)}
    return poses.from_rows([[columns[column][row] for column in range(3)] for row in range(3)])
