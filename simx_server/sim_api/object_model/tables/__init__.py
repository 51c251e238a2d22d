"""The properties of each class of API 2: those of API 1 under their new names and types, and the new ones."""
