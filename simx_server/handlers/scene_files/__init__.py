"""Files of scenes, models and meshes that clients and scripts name: finding, trying, reading and saving them."""
