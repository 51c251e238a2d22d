"""Values of a command line: arguments, text, images."""
