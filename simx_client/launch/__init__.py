"""Adaptations that ``simx-run`` makes for an unmodified legacy script; each one is independent of the others.

    bindings        replaces the script's vrep.py / sim.py when it is imported
    numpy_aliases   np.int and other names that NumPy removed
    numpy_arrays    float(a) of an array of one element, and other removed conversions
    matplotlib_aliases, libraries    fig.gca(projection='3d'); old names of Pillow and SciPy
    python_aliases  time.clock, inspect.getargspec and others that Python removed
    immutable, keywords  change types written in C, and functions with other keywords
    hints           one line where nothing can be restored
    paths           "folder\\file.jpg" means folder/file.jpg on POSIX
    windows         cv2.imshow, waitKey and the like, where OpenCV was built without windows
    after_import    applies these to a module as soon as it has been imported
    script          runs a file as ``__main__`` as ``python FILE`` does
    server          a private simx-server for the script

Everything applies to this process only; no file is edited. ``run`` puts it together.
"""
