"""PyRep, and RLBench on it, without CoppeliaSim: a stand-in for the C library below PyRep, over an embedded server.

A program imports it before PyRep::

    import simx_client.pyrep
    from pyrep import PyRep

or is started with ``simx-run --pyrep PROGRAM``, or with the variable ``SIMX_PYREP=1``. PyRep itself is not changed.

    finder          gives PyRep our module in place of its compiled one
    root            a folder that PyRep's installation takes for that of the simulator
    worlds          the simulations of this process, from launch to shutdown
    library         the functions by name; no exception leaves them
    plain           most functions: a table of arguments and results
    functions/      those that are more than a row of the table
    c_values        arguments of C as Python's values, and back
    declarations    the structure that cffi has to know; it writes `_ffi`
"""

from .finder import activate
from .root import root_folder

__all__ = ["activate", "root_folder"]

activate()
