"""Namespaces for meshes, and for files with meshes: simConvex, simOpenMesh, simAssimp, simURDF."""
