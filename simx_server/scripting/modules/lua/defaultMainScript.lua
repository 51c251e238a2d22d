-- The default main script. A scene's own main script may require it and replace some of these functions.
--
-- The server runs physics, sensors and customization scripts itself; the child scripts wait for this.

function sysCall_init() end

function sysCall_actuation() sim.handleChildScripts(sim.syscb_actuation) end

function sysCall_sensing() sim.handleChildScripts(sim.syscb_sensing) end

function sysCall_suspend() end

function sysCall_suspended() end

function sysCall_resume() end

function sysCall_cleanup() end

return true
