"""LeRobot's dataset format v3.0: tables of Parquet, statistics in JSON, a film of each camera and episode."""
