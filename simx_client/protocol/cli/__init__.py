"""What the command lines of the client and of the server share: parser, exit codes, install lines."""
