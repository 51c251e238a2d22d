"""``simx-server --doctor``: whether this machine has what the server needs, and what to do where it has not.

    findings     what a check has found: ok, warning or problem, and the next step
    machine      Python, packages, extras, cores, memory, the workspace
    network      ports, Zenoh talking to itself
    graphics     OpenGL back ends, a test picture
    child        checks that may crash or hang run in processes of their own
    page         all of them, for people and for programs

What needs a process of its own: `zenoh_probe`, `picture_probe`, and `sensors.gl_probe`.
"""
