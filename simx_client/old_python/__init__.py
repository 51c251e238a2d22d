"""Scripts written for Python 2: recognised, converted in memory, run.

    recognise    whether a file is Python 2, and by which construct
    convert      the text of a Python 2 file as Python 3; fissix converts the spelling
    meaning      what fissix leaves: division, rounding and other words with a changed meaning
    loading      which files are converted: the script and its modules

A converted text may need a name of ``simx_client.python2``; it then imports it in one line at its top. These
differences from Python 2 remain: ``print`` shows all digits of a float, not twelve; texts are Unicode, bytes
are not texts; None and numbers have no order. No file is written, not even a cache.
"""
