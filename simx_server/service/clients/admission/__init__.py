"""Counters over all doors: places for clients, and messages that have not arrived completely."""
