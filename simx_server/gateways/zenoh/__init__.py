"""The gateway of Zenoh, by which `simx_client` connects."""
