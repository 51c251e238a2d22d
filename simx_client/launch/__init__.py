"""What ``simx-run`` puts around an unmodified legacy script; each is one provision and knows no other.

    bindings        the carried vrep.py / sim.py is replaced when it is imported
    numpy_aliases   np.int and the others that NumPy dropped
    numpy_arrays    float(a) of an array of one element, and what else its arrays could do
    matplotlib_aliases, libraries    fig.gca(projection='3d'); old names of Pillow and SciPy
    python_aliases  time.clock, inspect.getargspec and others that Python itself dropped
    immutable, keywords  how types written in C, and functions with other keywords, are changed
    hints           one line where nothing can be given back
    paths           "folder\\\\file.jpg" means folder/file.jpg on POSIX
    windows         cv2.imshow, waitKey and the like, where OpenCV was built without windows
    after_import    how these reach a module: as soon as it has been imported
    python2         a script of Python 2, and its modules, converted in memory
    script          run a file as ``__main__`` the way ``python FILE`` does
    server          a simx-server of the script's own

All of it lives in this process only; no file is ever edited. ``run`` puts it together.
"""
