"""Ways in: each one turns what arrives into events of the engine, and answers into its own clothes."""
