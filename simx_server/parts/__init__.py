"""State that V-REP keeps beside physics: signals, parameters, drawing objects, graphs, tubes, user interface."""
