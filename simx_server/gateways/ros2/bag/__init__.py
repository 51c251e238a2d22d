"""Bags of ROS 2: the topics of a run as an MCAP file, for ``ros2 bag play`` and Foxglove; needs no ROS."""
