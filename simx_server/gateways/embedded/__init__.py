"""The gateway for a client in the server's own process: its thread executes its calls, without messages or queues."""
