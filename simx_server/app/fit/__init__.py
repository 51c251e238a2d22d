"""``simx fit``: values of a scene with which its runs meet recorded ones."""
