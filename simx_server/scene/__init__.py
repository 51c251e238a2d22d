"""The scene as V-REP sees it: objects, handles, names, frames, editing; on top of one compiled MuJoCo model."""
