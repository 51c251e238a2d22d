"""Facts about each kind of objects, and their records in V-REP's files."""
