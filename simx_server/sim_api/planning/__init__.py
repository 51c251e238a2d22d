"""Path and motion planning for scripts: `simOMPL`, and V-REP 3's motion planning."""
