"""Keys, access rules and options of Zenoh."""
