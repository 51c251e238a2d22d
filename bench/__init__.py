"""What a call, a pass and an image cost here, each beside the cheapest thing that does the same work.

``python -m bench`` runs every measurement and writes ``bench/REPORT.md``; ``python -m bench blocking --quick``
runs one of them shortly. Figures of one machine and one minute are compared with each other, never with
figures of another.
"""
