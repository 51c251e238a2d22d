"""The functions that the API offers, and those that a file lacks: lists for people, tools and the log of an import."""
