"""How V-REP's own files fare here: `python -m bench.imports FOLDER`."""
