"""The page in the browser: the live scene, everything in it, and who drives it.

The page is a process of its own (`python -m simx_server.viewer`), a client as any other: whatever it costs, physics
is not slowed, and when it fails the simulation goes on.

=====================  ===============================================================================
`feed.py`              in the server: what is there, copied, as an add-on that the page calls
`messages.py`          what the feed tells, as types
`launching.py`         in the server: ``--view`` starts the page's process, and ends it
`page/command.py`      the page's process: flags, parts
`page/gate.py`         the door: who may see the page
`page/composition.py`  makes the parts below, and keeps them up to date
`page/link.py`         its connections: `Eye` asks the feed, `Hands` do what people click
`page/mirror.py`       a copy of the server's model and state
`page/world.py`        the copy in 3-D, of `bodies.py` and `drawings.py`
`page/panels/`         one file a tab
=====================  ===============================================================================

Dependence: what is in `page/` uses `simx_client` as any client does, and viser, the extra ``viewer``; the server
imports nothing of it.
"""
