"""``simx export``: a recording in the format of another program."""
