"""A Pioneer drives along a path, and its sensors look around: paths and sensors of API 2 (CoppeliaSim 4.11).

simx-run --server pioneer_p3dx --zmq2 examples/api2/path_robot.py
"""

import math

WHEEL_RADIUS, HALF_AXLE = 0.0975, 0.166
AHEAD, SPEED = 0.25, 0.4
"""Distance at which the robot aims along the path (m), and its speed (m/s)."""


def main(sim, Path):
    """Drive, and return the share of the path that is left, and how many sensors see something at the end."""
    scene = sim.scene
    robot = scene.getObject("/Pioneer_p3dx")
    motors = [scene.getObject(f"/Pioneer_p3dx_{side}Motor") for side in ("left", "right")]
    sensors = robot.getDescendants({"types": ["proximitySensor"]})
    start = [float(each) for each in robot.getPosition().ravel()]
    corners = [
        start[:2],
        [start[0] + 0.6, start[1]],
        [start[0] + 0.6, start[1] + 0.8],
        [start[0], start[1] + 1.6],
    ]
    path = Path(list(zip(*corners, strict=True)), {"pathPoints": {"samplingDistance": 0.05}})
    path.createMarkers()
    length = path.data()["pathPoints"]["pathLength"]

    sim.self.setStepping(True)
    scene.simulation.start()
    share = 0.0
    while share < 0.98 and scene.simulation.time < 30:
        pose = [float(each) for each in robot.getPose()]
        heading = 2 * math.atan2(pose[5], pose[6])
        _, share = path.closest(pose[:2])
        x, y = (float(each) for each in path.getPoint(min(1.0, share + AHEAD / length)).ravel())
        turn = math.atan2(y - pose[1], x - pose[0]) - heading
        turn = math.atan2(math.sin(turn), math.cos(turn))
        for motor, side in zip(motors, (-1, 1), strict=True):
            motor.setTargetVelocity(
                (SPEED * max(0.2, math.cos(turn)) + side * HALF_AXLE * 2 * turn) / WHEEL_RADIUS
            )
        scene.signal.progress = float(share)
        sim.self.step()
    for motor in motors:
        motor.setTargetVelocity(0)
    sim.self.step()
    seen = [sensor.name for sensor in sensors if sensor.handleSensor()[0]]
    robot.customData.seen = seen
    scene.simulation.stop()
    return 1 - share, len(seen)


if __name__ == "__main__":
    import sim

    print("{:.0%} of the path is left, {} sensors see something".format(*main(sim, sim.Path)))
