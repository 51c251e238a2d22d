"""Messages of the server's add-ons, which travel in the buffers of a call."""
