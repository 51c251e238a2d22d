"""Provide ``cv2.imshow``, ``cv2.waitKey`` and the rest of HighGUI to a script whose OpenCV was built without
them.

    patch       decides whether the imported ``cv2`` needs them, and inserts the functions
    highgui     the functions: windows by name, keys, mouse, trackbars
    regions     ``selectROI`` and ``selectROIs``, made of these functions
    images      an image of any depth as bytes for a screen
    screen      messages to and from a screen: the interface between ``highgui`` and the two below
    display     real windows: a separate process (``desk``), independent of the script's pygame, Tk or Qt
    viewer      windows in the web viewer of the server that the script is connected to
    desk/       that process: layout and trackbars, over Tk or pygame

The screen is the display if there is one, else the web viewer if one runs, else none. Importing this package
loads neither ``cv2`` nor a window system.
"""
