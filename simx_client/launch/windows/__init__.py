"""Gives ``cv2.imshow``, ``cv2.waitKey`` and the rest of HighGUI back to a script whose OpenCV was built without them.

    patch       decides whether the imported ``cv2`` needs it, and puts the functions in place
    highgui     the functions: windows by name, keys, mouse, trackbars
    regions     ``selectROI`` and ``selectROIs``, made of these functions
    images      an image of any depth as bytes for a screen
    screen      what a screen is told and what it reports: the seam between ``highgui`` and the two below
    display     real windows: a process of its own (``desk``), so that the script's own pygame, Tk or Qt is not touched
    viewer      windows in the web viewer of the server that the script is connected to
    desk/       that process: layout and trackbars, over Tk or pygame

Which screen is used: the display where there is one, else the web viewer where one runs, else none. Importing this
package loads neither ``cv2`` nor a window system.
"""
