"""Teleoperation: an operator moves the tip of an arm, and inverse kinematics moves its joints.

An add-on receives the operator's commands, from the web viewer or a program, so that recordings have them as calls. ::

    `arms.py`      finds the arms of a scene, and what their motors obey
    `grippers.py`  finds the gripper of an arm, and moves it
    `arm_drive.py` moves the tip once in each simulation step, until the operator is silent
    `add_on.py`    the functions, as `simx_client.protocol.add_ons.teleoperation` describes them
"""
