"""The process that owns the windows: ``python -m simx_client.launch.windows.desk``, started by ``display``.

__main__    reads messages, keeps the window system going
windows     each window: layout of trackbars and image, from events to reports
painting    trackbars and lines of text as pixels
backend     what a window system has to offer: the seam
tk, sdl     Tk, and SDL by pygame
"""
