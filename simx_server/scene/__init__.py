"""The scene in V-REP's terms: objects, handles, names, frames, editing; based on one compiled MuJoCo model."""
