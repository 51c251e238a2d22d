"""The commands that talk to one simulator from a shell: call, watch, image; and the shells' completion.

connecting   which simulator is meant, and a connection to it
arguments    words of a command line as arguments of a function, by their kinds in the table
showing      values as text that can be given back as an argument, or as JSON
png          a picture as a file, without any image library
"""
