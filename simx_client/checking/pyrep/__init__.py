"""Programs of PyRep and RLBench.

calls       what they use
sentences   how to run them, what to install, what is missing
"""
