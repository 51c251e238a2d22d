"""The clients: their sessions and places."""
