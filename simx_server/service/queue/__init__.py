"""The queue of the physics thread: what arrives, in a fair order and within limits."""
