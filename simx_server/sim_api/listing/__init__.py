"""Lists of the API and of the gaps of a file: for people, tools and the log of an import."""
