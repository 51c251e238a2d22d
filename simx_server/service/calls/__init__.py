"""The calls of clients: from a message to the handler that executes it."""
