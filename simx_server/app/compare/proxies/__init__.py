"""Proxies between a program and a simulator: they forward all messages, and record calls, answers and states."""
