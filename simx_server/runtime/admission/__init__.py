"""What is counted at all doors together: places for clients, and messages that have not arrived completely."""
