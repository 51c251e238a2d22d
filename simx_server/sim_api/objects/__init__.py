"""Objects of the scene: finding, moving, measuring and changing them."""
