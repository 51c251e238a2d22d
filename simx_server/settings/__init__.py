"""The settings of a server: flags and variables as one frozen record, and the rules between them."""
