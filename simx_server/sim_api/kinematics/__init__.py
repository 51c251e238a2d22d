"""Inverse kinematics for scripts: V-REP 3's groups, and `simIK` of CoppeliaSim 4."""
