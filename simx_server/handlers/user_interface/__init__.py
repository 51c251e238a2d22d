"""Handlers for consoles, dialogs and custom UIs."""
