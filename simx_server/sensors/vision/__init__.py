"""Vision sensors: their images, filters and settings."""
