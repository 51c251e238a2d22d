"""The simulated world: the simulation, the parts around it, and the order of one simulation step."""
