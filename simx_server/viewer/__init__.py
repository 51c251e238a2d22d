"""The web viewer: the live scene, everything in it, and its clients.

The web viewer is a separate process (`python -m simx_server.viewer`) and a client like any other: it does not slow down
the physics, and the simulation goes on when it fails. ::

    `feed.py`              in the server: copies the scene and its state, as an add-on that the viewer calls
    `past.py`              in the server: describes a past step, of `simx_server.history`
    `inspection.py`        in the server: scripts, readings of sensors, files
    `messages.py`          the types of the feed's answers
    `launching.py`         in the server: ``--view`` starts the viewer's process, and ends it
    `windows.py`           in the server: the windows of scripts
    `page/command.py`      the viewer's process: flags, parts
    `page/gate.py`         access control: token and origin of browsers
    `page/composition.py`  makes the parts below, and updates them
    `page/link.py`         its connections: `Eye` reads from the feed, `Hands` execute clicks
    `page/mirror.py`       a copy of the server's model and state
    `page/view/world.py`        the copy in 3-D, of `bodies.py` and `drawings.py`
    `page/panels/`         one file per tab, and the time slider
    `page/tools/`          dragging, viewpoints, pictures and films, readings of sensors, files, plots

Dependence: `page/` uses `simx_client` as any client does, and viser, the extra ``viewer``; the server imports nothing
of it.
"""
