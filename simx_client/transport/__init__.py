"""The seam between a connection and the outside world, and its implementation over Zenoh."""
