"""The page's process, which is a client as any other; of the server's own modules it uses rules and types only."""
