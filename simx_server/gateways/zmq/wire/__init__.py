"""Bytes of the ZeroMQ remote API: frames of ZMTP, and the CBOR maps in them."""
