-- CoppeliaSim's class IK: worlds of inverse kinematics, which the server has, see sim.app:IK. The functions of simIK stay.

local app, simIK = require("sim-2").app, require("simIK")

local RENAMED = {
    constraint_alphabeta = "constraint_alpha_beta", calc_outoftolerance = "calc_notwithintolerance",
    calc_largesteps = "calc_stepstoobig", calc_boundshit = "calc_limithit",
}

return setmetatable({}, {
    __call = function() return app:IK() end,
    __index = function(_, name) return simIK[RENAMED[name] or name] end,
})
