"""One call: its mode, its values as messages carry them, its answer."""
