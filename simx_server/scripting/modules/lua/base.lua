-- Global functions of CoppeliaSim's Lua that are neither Lua's own nor `sim`'s.

local base = {}

function base.wrap(action, make) return make(action) end

function base.callmeta(value, name, default)
    local meta = getmetatable(value)
    local found = type(meta) == "table" and meta[name]
    if found == nil or found == false then return default end
    if type(found) == "function" then return found(value) end
    return found
end

function base.todisplay(value) return base.callmeta(value, "__todisplay") end

function base.display(value)
    local text = base.todisplay(value)
    if text then print(text) end
end

-- A table with the tables within it down to a depth.
function base.dump(value, depth)
    if type(value) ~= "table" or getmetatable(value) or depth == 0 then return value end
    local copy = {}
    for key, item in pairs(value) do copy[key] = base.dump(item, (depth or 1) - 1) end
    return copy
end

function base.getAsDisplayString(...) return getAsString(...) end
function base.help() print("The functions of sim: simx-server --script-functions") end

-- import "simIK" makes a module a global; import("functional", "map", "zip") its members, "*" all of them.
function base.import(name, ...)
    local names = { ... }
    if type(names[#names]) == "table" then table.remove(names) end
    local module_name = string.match(name, "^(.-)%.%*$")
    if module_name and #names == 0 then name, names = module_name, { "*" } end
    local module = require(name)
    if #names == 0 then
        require("var").setvar((string.gsub(name, "[-%d]+$", "")), module)
    elseif names[1] == "*" then
        for key, value in pairs(module) do _G[key] = value end
    end
    for _, key in ipairs(names) do
        if key ~= "*" then
            assert(module[key] ~= nil, "the module " .. name .. " has no " .. key)
            _G[key] = module[key]
        end
    end
end

-- Run a Lua file of the simulator's folder, as sim.include does.
function base.include(file, command) return sim.include(file, command) end

base.addLog, base.quitSimulator, base.loadPlugin = sim.addLog, sim.quitSimulator, sim.loadPlugin
base.quit, base.exit = sim.quitSimulator, sim.quitSimulator
base.setAutoYield, base.getAutoYield = sim.setThreadAutomaticSwitch, sim.getThreadAutomaticSwitch
base.setYieldAllowed, base.getYieldAllowed = sim.setThreadSwitchAllowed, sim.getThreadSwitchAllowed

function base.unloadPlugin() end

return base
