"""What calls and messages cost the server."""
