-- Functions of `sim` that CoppeliaSim wrote in Lua, and that only its Lua scripts have.

local added = {}

function added.getObjectsWithTag(tag, only_models)
    local found = {}
    for _, handle in ipairs(sim.getObjectsInTree(sim.handle_scene)) do
        local fits = not only_models or sim.getModelProperty(handle) & sim.modelproperty_not_model == 0
        if fits and table.find(sim.readCustomDataTags(handle) or {}, tag) then found[#found + 1] = handle end
    end
    return found
end

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

-- Referenced handles.

function added.getReferencedHandle(...)
    local handles = sim.getReferencedHandles(...)
    assert(#handles == 1, #handles == 0 and "no handle found" or "more than one handle found")
    return handles[1]
end

function added.addReferencedHandle(object, referenced, tag, options)
    if type(tag) == "table" then tag, options = "", tag end
    local handles = sim.getReferencedHandles(object, tag or "")
    table.extend(handles, options and options.wholeTree and sim.getObjectsInTree(referenced) or { referenced })
    sim.setReferencedHandles(object, handles, tag or "")
end

function added.removeReferencedObjects(object, tag)
    for _, handle in ipairs(sim.getReferencedHandles(object, tag or "")) do
        if sim.isHandle(handle) then
            local is_model = sim.getModelProperty(handle) & sim.modelproperty_not_model == 0
            if is_model then sim.removeModel(handle) else sim.removeObjects { handle } end
        end
    end
    sim.setReferencedHandles(object, {}, tag or "")
end

-- Named parameters and settings, which are texts.

local function flag_of(text)
    return text == "true" or text == "yes" or text == "on" or (tonumber(text) or 0) ~= 0
end

local function whole_of(text) return math.tointeger(tonumber(text) or "") end

local function named(name, convert)
    local text = sim.getNamedStringParam(name)
    return text and convert(text)
end

local function set(name, value) return sim.setNamedStringParam(name, tostring(value)) end

function added.getNamedBoolParam(name) return named(name, flag_of) end
function added.getNamedFloatParam(name) return named(name, tonumber) end
function added.getNamedInt32Param(name) return named(name, whole_of) end
function added.setNamedBoolParam(name, value) return set(name, value) end
function added.setNamedFloatParam(name, value) return set(name, value) end
function added.setNamedInt32Param(name, value) return set(name, value) end
function added.getSettingString(name) return named(name, tostring) end
function added.getSettingBool(name) return named(name, flag_of) end
function added.getSettingFloat(name) return named(name, tonumber) end
function added.getSettingInt32(name) return named(name, whole_of) end
function added.getStringNamedParam(name) return sim.getNamedStringParam(name) end
function added.setStringNamedParam(name, value) return sim.setNamedStringParam(name, value) end

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

-- Values.

function added.getQuaternionInverse(q) return { -q[1], -q[2], -q[3], q[4] } end
function added.boolAnd(a, b) return a & b end
function added.boolOr(a, b) return a | b end
function added.boolXor(a, b) return a ~ b end

-- A path that ends where it begins, and its times.
function added.closePath(path, times)
    local size = #path // #times
    local first, last = table.slice(path, 1, size), table.slice(path, #path - size + 1)
    local lengths = sim.getPathLengths(table.add(last, first), size)
    return table.add(path, first), table.add(times, { times[#times] + lengths[2] })
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

function added.getUserVariables()
    local found = {}
    for name, value in pairs(_G) do
        if type(value) ~= "function" and name ~= "_G" then found[name] = value end
    end
    return found
end

-- Functions without a meaning on a server: no windows, no menus, no code editor, one process.
function added.fastIdleLoop() end
function added.moduleEntry() return -1 end
function added.registerScriptFunction() return 1 end
function added.registerScriptVariable() return 1 end
function added.systemSemaphore() return true end
function added.getLastInfo() return "" end
function added.getLastError() return nil end
function added.getIsRealTimeSimulation() return sim.getRealTimeSimulation() end
function added.isDeprecated() return 0 end
function added.refreshDialogs() return 0 end

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
