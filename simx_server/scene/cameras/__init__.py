"""The image of a camera: its definition, the same for every renderer, and what it sees."""
