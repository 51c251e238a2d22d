"""The commands that talk to one simulator from a shell: call, watch, image; and completion scripts for
shells.

connecting   selects the simulator and connects to it
arguments    words of a command line as arguments of a function, by their kinds in the table
formatting   values as text that can be passed back as an argument, or as JSON
png          an image as a file, without an image library
"""
