"""A gateway as an outsider would write it: the remote API as lines of JSON over TCP."""
