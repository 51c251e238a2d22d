"""``simx diff``: where two recordings differ for the first time."""
