"""Implement ``simx-check``: what an old script needs, read from its text without running it.

program     the script and its modules, as syntax trees; Python 2 converted
search      finds these: beside it, on paths it adds (``folders``), installed ones that wrap a remote API
names       assignments to names, and calls with their arguments (``scopes``)
things      meaning of an expression: a module, a class, a function of the remote API (``passing``: by
callers)
texts       possible texts of an expression; parts known only at run time become ``*``
wants       the functions it calls, and the objects, scripts, signals, files and ports it names
idioms      habits for which a difference from the original matters
pyrep       programs of PyRep and RLBench
elsewhere   programs for other remote APIs
scene       what is missing in a scene
findings    the sentences, as text and as records
command     the command line
"""
