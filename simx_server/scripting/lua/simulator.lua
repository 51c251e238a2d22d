-- Names that CoppeliaSim's Lua has beside Lua's own. The modules that define them are loaded at the first use.
--
-- Arguments: the script's world, and a function that returns whether the script assigns a variable of a name.
-- Modules run with the rights of the script.

local world, assigns = ...
local rawget, type, pairs, pcall, gmatch, setmetatable, require = rawget, type, pairs, pcall, string.gmatch,
    setmetatable, world.require

local homes = {}
for module, names in pairs {
    matrix = "Matrix Matrix3x3 Matrix4x4 Vector Vector3 Vector4 Vector7",
    base = "addLog callmeta display dump exit getAsDisplayString getAutoYield getYieldAllowed help import include "
        .. "loadPlugin quit quitSimulator setAutoYield setYieldAllowed todisplay unloadPlugin wrap",
    functional = "all any apply filter foreach identity iter map negate operator partial prod range reduce sum "
        .. "zip",
} do
    for name in gmatch(names, "%S+") do homes[name] = module end
end

-- A library that asks its module for a function which it lacks.
for library, module in pairs { math = "mathx", string = "stringx", table = "tablex" } do
    local is_loaded = false
    setmetatable(world[library], {
        __index = function(members, name)
            if is_loaded then return nil end
            is_loaded = true
            pcall(require, module)
            return rawget(members, name)
        end,
    })
end

-- A variable that the script itself assigns is nil until then, as in V-REP 3, which had few of these names.
-- The functions of `sim` are looked up with its name as the second argument.
return function(name, space)
    if space then
        local ok, added = pcall(require, "sim_functions")
        return ok and type(added) == "table" and rawget(added, name) or nil
    end
    local home = homes[name]
    if not home or assigns(name) then return nil end
    local ok, members = pcall(require, home)
    return rawget(world, name) or ok and type(members) == "table" and members[name] or nil
end
