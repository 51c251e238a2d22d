"""What objects with a `simx:ros2` annotation offer: scans, ranges, odometry, drives, IMUs, groups of joints."""
