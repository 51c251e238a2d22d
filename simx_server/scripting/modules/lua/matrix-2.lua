-- CoppeliaSim's matrices and vectors, as members of the module.

require("linear.algebra")
local found = { Matrix = require("linear.matrix").Matrix }
for _, part in ipairs { "linear.vectors", "linear.poses" } do
    for name, class in pairs(require(part)) do found[name] = class end
end
return found
