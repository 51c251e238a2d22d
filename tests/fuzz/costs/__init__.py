"""The cost of calls and messages for the server."""
