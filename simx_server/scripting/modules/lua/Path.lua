-- CoppeliaSim's class Path of API 2: the server has the paths, see sim.app:Path.

local app = require("sim-2").app

local Path = {}
for _, name in ipairs { "fromObject", "fromJoints", "fromBuffer" } do
    Path[name] = function(...) return app["Path." .. name](app, ...) end
end
return setmetatable(Path, { __call = function(_, points, options) return app["Path"](app, points, options) end })
