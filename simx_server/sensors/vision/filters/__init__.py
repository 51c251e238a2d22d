"""Image processing in vision sensors: the filters of scripts, and chains of them that a sensor has."""
