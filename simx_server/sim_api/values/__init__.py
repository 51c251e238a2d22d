"""Arithmetic on plain values: bits, buffers, matrices, packed strings."""
