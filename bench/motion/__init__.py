"""How well things move: held objects that must not creep."""
