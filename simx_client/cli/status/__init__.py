"""Implement ``simx status``: health and metrics of servers, as text, as JSON and for Prometheus."""
