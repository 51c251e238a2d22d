"""The geometry of shapes: from the leaves of a V-REP shape to geoms, meshes, materials and textures of a spec."""
