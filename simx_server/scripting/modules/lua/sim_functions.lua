-- Functions of `sim` that CoppeliaSim wrote in Lua, and that only its Lua scripts have.

local added = {}

-- A table whose functions are those of a script: of a script's handle or path, or of an object's script of a type.
function added.getScriptFunctions(target, kind)
    if type(target) == "string" then target = sim.getObject(target) end
    local is_object, object_type = pcall(sim.getObjectType, target)
    if is_object and object_type ~= sim.sceneobject_script then
        target = sim.getScript(kind or sim.scripttype_customization, target)
    end
    return setmetatable({}, { __index = function(_, name)
        return function(_, ...) return sim.callScriptFunction(name, target, ...) end
    end })
end

-- Data.

function added.readCustomDataBlockEx(handle, tag, options)
    local data = sim.readCustomStringData(handle, tag)
    if tag == "__info__" then return data, "cbor" end
    local blocks = sim.readCustomTableData(handle, "__info__").blocks
    return data, blocks and blocks[tag] and blocks[tag].type or options and options.dataType
end

function added.writeCustomDataBlockEx(handle, tag, data, options)
    sim.writeCustomStringData(handle, tag, data)
    if tag == "__info__" or not (options and options.dataType) then return end
    local info = sim.readCustomTableData(handle, "__info__")
    info.blocks = info.blocks or {}
    info.blocks[tag] = { type = options.dataType }
    sim.writeCustomTableData(handle, "__info__", info)
end

-- Collections, with the names of CoppeliaSim 4.8.

function added.createCollectionEx(options) return sim.createCollection(options or 0) end

function added.addToCollection(collection, object, what, options)
    return sim.addItemToCollection(collection, what or sim.handle_single, object, options or 0)
end

-- Calls and scripts.

local called = setmetatable({}, { __mode = "k" })

-- Call a function now if its last call is longer ago than `seconds`; else leave it out.
function added.throttle(seconds, action, ...)
    local now = sim.getSystemTime()
    if called[action] and now < called[action] + seconds then return end
    called[action] = now
    action(...)
end

function added.executeLuaCode(text)
    local chunk = load(text)
    if not chunk then return false, "compilation error" end
    return pcall(chunk)
end

local libraries = {}
for name in string.gmatch("_G _VERSION coroutine debug io math os package string table utf8", "%S+") do
    libraries[name] = true
end

-- Whether the server gave a variable: a library of Lua, or a namespace such as `sim`.
local function is_given(name, value)
    if libraries[name] then return true end
    if type(value) ~= "table" or not string.match(name, "^sim") then return false end
    local is_there, space = pcall(require, name)
    return is_there and space == value
end

-- The variables of the script itself, by name.
function added.getUserVariables()
    local found = {}
    for name, value in pairs(_G) do
        if type(value) ~= "function" and not is_given(name, value) then found[name] = value end
    end
    return found
end

-- Functions without a meaning on a server: no windows, no menus, no code editor, one process.

-- A file by its path from the scene's folder, or by its whole path: modules lie beside the scene.
function added.includeRel(file, command) return sim.include(file, command) end
function added.includeAbs(file, command) return sim.include(file, command) end

-- Names of V-REP 3.

function added.getObjectHandle_noErrorNoSuffixAdjustment(name) return sim.getObjectHandle(name .. "#@silentError") end

function added.UI_populateCombobox(ui, id, items, excluded, current, is_sorted, first)
    local handles, texts, rest = {}, {}, {}
    for _, item in ipairs(items) do
        if not (excluded and excluded[item[1]]) then rest[#rest + 1] = item end
    end
    if is_sorted then table.sort(rest, function(a, b) return a[1] < b[1] end) end
    local index = 0
    for i, item in ipairs(table.add(first or {}, rest)) do
        handles[i], texts[i] = { item[1], item[2] }, item[1]
        if item[1] == current then index = i - 1 end
    end
    simUI.setComboboxItems(ui, id, texts, index, true)
    return handles, index
end

return added
