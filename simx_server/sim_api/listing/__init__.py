"""What the API offers and what a file lacks of it: lists for people, tools and the log of an import."""
