"""Point clouds and octrees: their contents, and how images and sensors get to see them."""
