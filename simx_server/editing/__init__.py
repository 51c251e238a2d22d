"""Changes of a whole world: copying, creating, grouping and scaling objects, adding models."""
