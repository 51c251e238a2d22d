"""The compiled form of least squares: one C file, which does what the modules beside this folder do in Python."""
