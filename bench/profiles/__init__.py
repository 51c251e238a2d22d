"""Where the time of an operation goes, by function: for the aims that are not reached."""
