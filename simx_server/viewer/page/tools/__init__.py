"""Tools beside the tabs: one file per tool. Each does what a click asks for, as a client with its rights."""
