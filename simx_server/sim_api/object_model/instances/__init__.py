"""Objects of API 2 that programs make beside the scene: paths, worlds of inverse kinematics, objects of own classes."""
