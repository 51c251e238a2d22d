"""The web viewer's process, a client like any other; of the server's modules it uses rules and types only."""
