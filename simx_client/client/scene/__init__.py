"""The objects of the scene for new code: poses, joints, sensors, cameras."""
