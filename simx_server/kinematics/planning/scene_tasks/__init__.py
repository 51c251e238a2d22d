"""The planning tasks that a scene of V-REP 3 brings along: for paths, and for the joints of a robot."""
