"""Values that cross the border between Python and a script."""
