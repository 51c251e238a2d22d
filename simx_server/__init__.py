"""simx_server: owns a world simulated by MuJoCo and serves it as V-REP did.

It imports only ``simx_client.protocol`` of the client. The packages, from the outside in:

app           flags and environment variables become one frozen `Settings`; composition; ``--doctor``
gateways      the transports: Zenoh, and in-process for tests
runtime       the server loop: inbox, batches, dispatch, executor, sessions, streams, outbox; metrics
handlers      one function per command of the table
world         the simulation and its parts; the stages of one simulation step
parts         V-REP's features beside physics: signals, parameters, drawing objects, graphs, user interface
scripting     the scene's scripts in Lua and Python, and the ``sim`` that they see
joints, kinematics, sensors
scene         objects, names, handles; geometry, file formats, editing, trials of clients' files
recording, outputs, viewer
files         search for scenes, the workspace, checks of references in files
processes     parent, end and memory of the server's process
"""

from simx_client.protocol.version import __version__ as __version__
