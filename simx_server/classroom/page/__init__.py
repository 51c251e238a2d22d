"""The page of a class, in a process between browsers and seats: an HTTP server, and the channels to the seats."""
