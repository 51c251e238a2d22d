-- A class of a script's own: CustomClass('name', options). Functions that are assigned to it become methods of its objects.

local sim = require("sim-2")

local CustomClass = {}

function CustomClass:__index(name)
    local class = rawget(self, "__class")
    local found = class[name]
    if type(found) ~= "function" then return found end
    return function(_, ...) return found(class, ...) end
end

function CustomClass:__newindex(name, value)
    assert(type(value) == "function", "a function becomes a method; set properties with setFloatProperty and its like")
    rawget(self, "__class"):setMethodProperty(name, value)
end

return function(name, options)
    for _, class in ipairs(sim.app.customClasses) do
        if class.type == name then return setmetatable({ __class = class }, CustomClass) end
    end
    return setmetatable({ __class = sim.app:createCustomObjectClass(name, options or {}) }, CustomClass)
end
