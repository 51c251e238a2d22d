"""CoppeliaSim's properties: one table of names, each with its type, and how it is read and set."""
