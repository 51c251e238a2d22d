"""Many clients, many servers, floods, start-up and the web viewer."""
