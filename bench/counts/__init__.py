"""What a call, a simulation step and an image make Python do, in numbers that do not depend on the machine."""
