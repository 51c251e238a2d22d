"""What a call of a client of the ZeroMQ remote API costs."""
