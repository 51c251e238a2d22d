"""Gateways: each one turns incoming messages into events of the server loop, and sends the answers back."""
