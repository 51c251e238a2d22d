"""Build a scene of shapes, a hinge, a sensor and a camera, with data and signals: objects of API 2 (CoppeliaSim 4.11).

simx-run --server empty --zmq2 examples/api2/scene_builder.py
"""

WHITE, RED = [1.0, 1.0, 1.0], [1.0, 0.0, 0.0]


def main(sim, takes_image=True):
    """Build the scene, run it for a second, and return the measurements."""
    scene = sim.scene
    table = scene.createObject(
        {"type": "shape", "name": "table", "cuboid": {"size": [0.8, 0.8, 0.1]}, "respondable": True}
    )
    table.setPosition([0.0, 0.0, 0.05])
    table.color.diffuse = WHITE
    balls = []
    for place in range(3):
        ball = scene.createObject(
            {
                "type": "shape",
                "name": f"ball{place}",
                "spheroid": {"radius": 0.05},
                "dynamic": True,
                "respondable": True,
                "mass": 0.2,
                "color.diffuse": RED,
            }
        )
        ball.setPosition([0.2 * place - 0.2, 0.0, 0.4])
        ball.customData.order = place
        ball.customData.home = ball.pose
        balls.append(ball)
    door = scene.createObject(
        {"type": "joint", "name": "door", "joint.type": "revolute", "dynamics.ctrlMode": "velocity"}
    )
    door.setPosition([0.4, 0.4, 0.3])
    leaf = scene.createObject(
        {"type": "shape", "name": "leaf", "cuboid": {"size": [0.3, 0.02, 0.3]}, "dynamic": True}
    )
    leaf.setPosition([0.56, 0.4, 0.3])
    leaf.setParent(door)
    door.targetForce, door.targetVelocity = 10.0, 0.5
    eye = scene.createObject({"type": "proximitySensor", "proximitySensor.type": "ray", "volume.range": 1.0})
    eye.setPose([-0.2, 0.0, 0.9, 1.0, 0.0, 0.0, 0.0])
    camera = scene.createObject({"type": "visionSensor", "resolution": [32, 16]})
    camera.setPose([0.0, 0.0, 1.5, 1.0, 0.0, 0.0, 0.0])
    group = scene.createObject({"type": "collection"})
    for ball in balls:
        group.addItem(ball)
    marks = scene.createObject({"type": "marker", "marker.type": "spheres", "itemSize": [0.01] * 3})
    scene.signal.built = len(scene.getObjects(["shape"]))

    sim.self.setStepping(True)
    scene.simulation.start()
    while scene.simulation.time < 1.0:
        sim.self.step()
        marks.addItems([[float(value)] for value in balls[0].getPosition().ravel()])
    detected, distance, _, seen, _ = eye.handleSensor()
    image, resolution = camera.getImage() if takes_image else (b"", [0, 0])
    measured = {
        "order": [ball.customData.order for ball in balls],
        "heights": [float(ball.getPosition().ravel()[2]) for ball in balls],
        "homes": [float(ball.customData.home[2]) for ball in balls],
        "door": float(door.joint.position),
        "seen": seen.name if detected else "",
        "distance": float(distance),
        "image": (len(image), list(resolution)),
        "members": len(group.objects),
        "marks": marks.points.shape[1],
        "built": scene.signal.built,
    }
    scene.simulation.stop()
    return measured


if __name__ == "__main__":
    import sim

    for name, value in main(sim).items():
        print(name, value)
