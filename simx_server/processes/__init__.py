"""The server as a process of its machine: its parent, its end, its memory."""
