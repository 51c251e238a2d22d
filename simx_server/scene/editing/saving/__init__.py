"""Prepare a scene's spec for saving.

* `settling.py`: what commands have written into the model's arrays goes into the spec
* `naming.py`: elements get the names of their objects
"""
