"""simx_server: owns a world simulated by MuJoCo and lets anyone drive it as if it were V-REP.

Who may import whom, from the outside in; nothing imports upwards, and of the client only
``simx_client.protocol`` (the table, the kinds, the wire) is known here:

    cli, settings                 flags and environment become one frozen ``Settings``
    server                        the composition; nothing else knows all parts
    gateways, engine, streams     calls come in, are put in order, are answered
    handlers                      one function per command of the table
    simulation, joints, sensors   the only owner of MjModel and MjData, and what moves and looks in it
    scene                         names, handles, hierarchy, frames, loading and editing
"""

from simx_client.protocol.version import __version__ as __version__
