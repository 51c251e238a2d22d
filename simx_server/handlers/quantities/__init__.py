"""The numbered quantities of objects, of the engine and of the simulator; the named properties are views of them."""
