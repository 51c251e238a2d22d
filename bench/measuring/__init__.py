"""The machine, processes to measure, baselines, and the report."""
