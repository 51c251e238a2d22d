"""The standard ``simulation_interfaces`` beyond the run: features, entities, spawning, worlds, named poses."""
