"""Windows that scripts make from XML with `simUI`, V-REP's Qt-based custom UIs: `reading.py` explains their form."""
