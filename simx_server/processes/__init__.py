"""The server as a process: its parent, its end, its memory."""
