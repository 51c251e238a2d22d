"""The program ``simx-server``: flags become frozen settings, settings become a running server."""
