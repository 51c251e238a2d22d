"""Answers: replies to calls, values of streams, and when they leave."""
