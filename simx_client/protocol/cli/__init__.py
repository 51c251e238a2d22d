"""Code shared by the command lines of the client and of the server: parser, exit codes, install lines."""
