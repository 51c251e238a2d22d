"""``simx-check``: what an old script wants, read from its text without running it.

program     the script and the modules beside it, as syntax trees; Python 2 converted
names       who assigns what to which name, and who calls whom with what
texts       which texts an expression may be; what is known only at run time becomes ``*``
wants       the functions it calls, and the objects, scripts, signals, files and ports it names
scene       what a scene lacks of that
findings    the sentences, as text and as records
command     the command line
"""
