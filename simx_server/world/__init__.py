"""The composition: the world of a server as one value, and the order of one simulation step."""
