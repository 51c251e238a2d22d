"""Implement ``simx mcp``: a simulation for agents, by the Model Context Protocol."""
