"""What a node of ROS 2 costs the physics thread."""
