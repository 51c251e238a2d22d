"""Counters of the server and the reports made from them."""
