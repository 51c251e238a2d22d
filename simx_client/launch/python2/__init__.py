"""Scripts written for Python 2: recognised, converted in memory, run.

    recognise    is it Python 2, where, and by what construct
    convert      the text of a Python 2 file as Python 3; fissix does the spelling
    meaning      what fissix leaves: division, rounding and other words that kept their look and changed their sense
    loading      which files are converted: the script itself, the modules it brings

A converted text may need a name of ``simx_client.python2``; it then imports it in one line at its top.
What still differs from Python 2: ``print`` shows all digits of a float, not twelve; texts are Unicode, bytes are not
texts; None and numbers have no order.
No file is written, not even a cache: beside the script lies what lay there before.
"""
