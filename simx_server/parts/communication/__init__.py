"""How scripts and clients exchange data: signals, tubes, wireless messages, ports, messages of the simulator."""
