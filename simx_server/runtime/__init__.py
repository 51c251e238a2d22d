"""The server loop: batches of calls come in, handlers execute them, replies and streams go out."""
