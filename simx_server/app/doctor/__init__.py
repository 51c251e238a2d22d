"""``simx-server --doctor``: check that this machine has what the server needs, with advice where it has not.

    findings     the result of a check: ok, warning or problem, and the next step
    machine      Python, packages, extras, cores, memory, the workspace
    network      ports, a Zenoh connection on this machine
    graphics     OpenGL back ends, a test image
    child        separate processes for checks that may crash or hang
    page         all checks, for people and for programs

Run in a separate process: `zenoh_probe`, `image_probe`, and `sensors.gl_probe`.
"""
