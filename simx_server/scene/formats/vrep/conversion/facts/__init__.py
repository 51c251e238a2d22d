"""Facts of a V-REP file beside its elements: scripts, data, collections, pairs, IK groups, settings."""
