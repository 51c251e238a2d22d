"""The compiled form of the decoder of V-REP's files: one C file, which does what `huffman.py` does in Python."""
