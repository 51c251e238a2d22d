"""How rmw_zenoh writes a node: key expressions, liveliness tokens, QoS, attachments; and the session with these."""
