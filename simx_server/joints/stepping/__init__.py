"""Physics steps: motors, position controllers and scripts command the joints before or within each of them."""
