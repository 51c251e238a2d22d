"""simx_server: owns a world simulated by MuJoCo and serves it as V-REP did.

It imports only ``simx_client.protocol`` of the client. The packages, from the outside in:

app           flags and environment variables become one frozen `Settings`; the lists of gateways and watchers
gateways      a folder for each protocol; bytes end here
service       the service of clients: queue, calls, answers, clients, metrics; the loop of the physics thread
handlers      one function per command of the table
sim_api       the functions of the ``sim`` object, for scripts and ZeroMQ
editing       what edits a whole world: copies, models, compounds
world         the composition: every part of a world, and the stages of one simulation step
parts         V-REP's features beside physics: signals, parameters, drawing objects, graphs, user interface
scripting     the interpreters of the scene's scripts, in Lua and Python
sensors, kinematics
simulation    the kernel: model, data and time; start and stop
joints        joints, their controllers, and the physics steps
scene         objects, names, handles; geometry, file formats, trials of clients' files
recording, history, outputs, viewer, classroom
files         search for scenes, the workspace, checks of references in files
processes     parent, end and memory of the server's process
"""

from simx_client.protocol.version import __version__ as __version__
