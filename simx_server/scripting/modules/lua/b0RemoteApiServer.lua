-- The server of the B0-based remote API: in CoppeliaSim it answers programs that use this API.

sim.addLog(
    sim.verbosity_scriptinfos + sim.verbosity_once,
    "the B0-based remote API is not there: programs use the legacy or the ZeroMQ remote API"
)

return {}
