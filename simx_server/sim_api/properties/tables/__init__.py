"""The properties of each kind of target: names, types, and how they are read and set."""
