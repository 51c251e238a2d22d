"""The process that owns the windows: ``python -m simx_client.launch.windows.desk``, started by ``display``.

__main__    reads messages, runs the window system
windows     each window: layout of trackbars and image, from events to reports
painting    trackbars and lines of text as pixels
backend     the interface of a window system
tk, sdl     Tk, and SDL by pygame
"""
