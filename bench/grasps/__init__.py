"""Grippers of PyRep and RLBench grasp by force, carry and hold: ``python -m bench.grasps --pyrep PATH --rlbench PATH``.

Physics is deterministic, so the numbers are those of the code and not of the machine.
"""
