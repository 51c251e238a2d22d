"""Scripts in Lua: the interpreter, its sandbox and its limits."""
