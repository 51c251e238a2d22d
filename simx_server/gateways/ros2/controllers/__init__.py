"""Controllers of arms and grippers, as actions: ``FollowJointTrajectory`` and ``GripperCommand``."""
