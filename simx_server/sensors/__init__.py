"""What a simulated sensor sees: cameras and the render thread; proximity, force and contacts beside them.

Importing this package loads neither mujoco nor OpenGL; the modules load what they need.
"""
