"""Motion: profiles, moves, inverse kinematics and path planning."""
