"""What robots do, in numbers, beside what they should: ``python -m bench.motion`` writes `docs/internals/motion.md`.

Physics is deterministic, so the numbers are those of the code and not of the machine. Only the column with the share of
real time depends on it.
"""
