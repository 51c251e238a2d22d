"""How scripts exchange data with each other and with clients."""
