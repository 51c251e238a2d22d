"""A UR5 takes a cube to a mark: inverse kinematics of API 2 (CoppeliaSim 4.11).

simx-run --server pick_place --zmq2 examples/api2/pick_place.py
"""

import math

DOWN = [math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0]
"""Quaternion x, y, z, w of a hand that points downwards."""


def main(sim, IK):
    """Move the cube, and return how far from the mark it lies, in metres."""
    scene = sim.scene
    robot, tip = scene.getObject("/UR5"), scene.getObject("/UR5_ikTip")
    cube, mark = scene.getObject("/Cube"), scene.getObject("/Mark")
    cube.setPosition([-0.1, 0.0, 0.025])
    mark.setPosition([-0.1, 0.3, 0.001])
    goal = scene.createObject({"type": "dummy", "name": "goal"})

    ik = IK()
    group = ik.createGroup({"method": "dampedLeastSquares", "damping": 0.05, "maxIterations": 60})
    group.addElementFromScene(robot, tip, goal, IK.constraint_pose)

    def reach(place, height, steps):
        """Move the hand to a height above a place in a straight line."""
        start = [float(each) for each in tip.getPosition().ravel()]
        end = [float(place[0]), float(place[1]), height]
        turn = [float(each) for each in tip.getQuaternion().ravel()]
        for step in range(1, steps + 1):
            share = step / steps
            goal.setPosition([a + share * (b - a) for a, b in zip(start, end, strict=True)])
            goal.setQuaternion(turn)
            group.solve({"ignoreTolerance": True})
            sim.self.step()

    def grip(closed):
        scene.signal.RG2_open = 0 if closed else 1
        for _ in range(30):
            sim.self.step()

    sim.self.setStepping(True)
    scene.simulation.start()
    pose = [*cube.getPosition().ravel()[:2], 0.3, *DOWN]
    elbow, wrist = (ik.objects[scene.getObject(f"/UR5_joint{number}").handle] for number in (3, 4))

    def is_above(angles, _joints):
        return (
            angles
            if min(each.getPosition().ravel()[2] for each in (elbow, wrist)) > 0.4 and abs(angles).max() < 3
            else None
        )

    angles, described = group.findConfig([pose], {"maxTime": 5, "callback": is_above})
    arm = [sim.Object(item["joint"].sceneObjectHandle) for item in described]
    for joint, angle in zip(arm, angles.ravel(), strict=True):
        joint.setTargetPosition(float(angle), {"maxVelocity": 1.0})
    for _ in range(80):
        sim.self.step()
    grip(closed=False)
    reach(cube.getPosition().ravel(), 0.03, 60)
    grip(closed=True)
    reach(cube.getPosition().ravel(), 0.25, 40)
    reach(mark.getPosition().ravel(), 0.25, 60)
    reach(mark.getPosition().ravel(), 0.03, 40)
    grip(closed=False)
    reach(mark.getPosition().ravel(), 0.25, 40)
    distance = math.dist(cube.getPosition().ravel()[:2], mark.getPosition().ravel()[:2])
    scene.simulation.stop()
    sim.app.logInfo(f"{len(arm)} joints have put the cube {1000 * distance:.0f} mm from the mark")
    return distance


if __name__ == "__main__":
    import sim

    print(f"{1000 * main(sim, sim.IK):.0f} mm from the mark")
