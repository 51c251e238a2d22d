"""The gateway within a process, for tests: messages without a network."""
