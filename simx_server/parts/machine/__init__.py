"""The machine around the simulation: serial ports and programs that scripts use, and what they get from there."""
