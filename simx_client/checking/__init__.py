"""``simx-check``: what an old script wants, read from its text without running it.

program     the script and its own modules, as syntax trees; Python 2 converted
search      where these are: beside it, on paths it adds (``folders``), installed ones that wrap a remote API
names       who assigns what to which name, and who calls whom with what (``scopes``)
things      what an expression stands for: a module, a class, a function of the remote API (``passing``: by callers)
texts       which texts an expression may be; what is known only at run time becomes ``*``
wants       the functions it calls, and the objects, scripts, signals, files and ports it names
idioms      habits that make a difference from the original matter
elsewhere   programs for other remote APIs
scene       what a scene lacks of that
findings    the sentences, as text and as records
command     the command line
"""
