"""Contents of widgets that are more than a text or a number: plots, trees, edited texts."""
