"""Types of the official Python client for editors and type checkers: a package of stubs made from our tables.

``python -m simx_server.gateways.zmq.stubs`` writes the files; a test fails when one is stale.
"""
