"""The kernel: model, data and time of the simulation, start and stop, and the physics step."""
