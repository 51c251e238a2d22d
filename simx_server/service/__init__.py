"""The service of clients: the loop of the physics thread, its queue, its calls and its answers."""
