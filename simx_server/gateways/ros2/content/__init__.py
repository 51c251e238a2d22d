"""The offers of every scene to ROS 2: time, joints, transforms, images, commands of joints, control of the run."""
