"""Convert a file to a scene and back: MJCF, URDF, and the annotations that complete them."""
