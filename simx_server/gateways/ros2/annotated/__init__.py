"""Topics of objects with a `simx:ros2` annotation: scans, ranges, odometry, drives, IMUs, groups of joints."""
