"""Counters over all gateways: places for clients, and messages that have not arrived completely."""
