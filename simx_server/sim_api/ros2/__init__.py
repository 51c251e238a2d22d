"""``simROS2``: topics and services of scripts, which the gateway of ROS 2 offers; without it nothing is connected."""
