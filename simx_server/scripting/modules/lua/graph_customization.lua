-- The customization of a graph: in CoppeliaSim it draws the graph's window and a dialog of its settings.
--
-- Graphs record without it, and the web viewer draws them; so nothing is left to do here.

sim.addLog(
    sim.verbosity_scriptinfos + sim.verbosity_once,
    "graphs open no window: the web viewer draws them (--view)"
)

return {}
