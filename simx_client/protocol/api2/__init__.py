"""API 2 of CoppeliaSim 4.11 as programs see it: objects whose members are properties and methods of the server."""
