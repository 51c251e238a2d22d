"""The legacy remote API: the ``simx`` functions, their operation modes, and what they return."""
