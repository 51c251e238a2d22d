"""Costs of Python itself, and how this project saves them."""
