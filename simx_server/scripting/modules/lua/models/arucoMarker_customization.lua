-- The customization of an ArUco marker: in CoppeliaSim a dialog chooses the marker, which is then painted.
--
-- The marker keeps the picture that the file has.

sim.addLog(
    sim.verbosity_scriptinfos + sim.verbosity_once,
    "the dialogs of ArUco markers are not there; the markers keep their pictures"
)

return {}
