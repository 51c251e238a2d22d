"""Functions of ``sim`` for paths: the path objects of V-REP 3, and the paths of CoppeliaSim 4 as lists of numbers."""
