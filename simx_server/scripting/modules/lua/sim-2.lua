-- CoppeliaSim's API 2: objects with properties and methods, over sim.callMethod.
--
-- An object is a table with a handle. Reading a member asks for its type first: a method becomes a function, a group
-- (customData, simulation ...) a table of its own, everything else is read. The answers about types are kept by class.

local api_1 = require("sim")
local eigen, Color, Buffer = require("simEigen"), require("Color"), require("Buffer")
local Matrix = eigen.Matrix
local invoke = api_1.callMethod

local SELF, SCENE, APP = -4, -12, -13
local GROUP, METHOD = 24, 240
local MARK = "@"

local Object, ObjectArray, PropertyGroup = {}, {}, {}

local sim = { version = 2, Object = Object, ObjectArray = ObjectArray, PropertyGroup = PropertyGroup }

-- Values: as sim.callMethod takes and returns them.

local decode, encode

local function object(handle)
    if handle == -1 then return nil end
    return setmetatable({ __handle = handle }, Object)
end

local DECODED = {
    object = object, buffer = Buffer,
    matrix = function(value) return Matrix(value[1], value[2], value[3]):freeze() end,
    pose = function(value) return eigen.Pose(value):freeze() end,
    quaternion = function(value) return eigen.Quaternion(value):freeze() end,
    color = function(value) return Color.ofbytes(value) end,
}

function decode(value)
    if type(value) ~= "table" then return value end
    local kind = rawget(value, MARK)
    if kind and DECODED[kind] then return DECODED[kind](value.value) end
    for key, item in next, value do
        if type(item) == "table" then value[key] = decode(item) end
    end
    return value
end

local function decode_all(...)
    local count = select("#", ...)
    if count == 0 then return end
    if count == 1 then return decode((...)) end
    local values = table.pack(...)
    for i = 1, count do values[i] = decode(values[i]) end
    return table.unpack(values, 1, count)
end

local function marked(kind, value) return { [MARK] = kind, value = value } end

-- A function of the script gets objects, and its results leave as they must.
local function encode_function(action)
    return function(...)
        local results = table.pack(action(decode_all(...)))
        for i = 1, results.n do results[i] = encode(results[i]) end
        return table.unpack(results, 1, results.n)
    end
end

function encode(value)
    if type(value) == "function" then return encode_function(value) end
    if type(value) ~= "table" then return value end
    local meta = getmetatable(value)
    if meta == Object then return marked("object", rawget(value, "__handle")) end
    if meta == Buffer then return marked("buffer", tostring(value)) end
    if meta == Color then return marked("color", value:bytes()) end
    if meta == eigen.Quaternion then return marked("quaternion", value:data()) end
    if meta == eigen.Pose then return marked("pose", value:data()) end
    if eigen.ismatrix(value) then return marked("matrix", { value:rows(), value:cols(), value:data() }) end
    local copy = {}
    for key, item in next, value do copy[key] = type(item) == "table" and encode(item)
        or type(item) == "function" and encode_function(item) or item end
    return copy
end

local function handle_of(target)
    if getmetatable(target) == Object then return rawget(target, "__handle") end
    if getmetatable(target) == PropertyGroup then return rawget(rawget(target, "__owner"), "__handle") end
    return target
end

local function call(target, name, ...)
    local count = select("#", ...)
    if count == 0 then return decode_all(invoke(handle_of(target), name)) end
    local values = table.pack(...)
    for i = 1, count do values[i] = encode(values[i]) end
    return decode_all(invoke(handle_of(target), name, table.unpack(values, 1, count)))
end

-- Types of members, by class.

local SILENT = { noError = true }
local known = {}                                                -- class -> name -> type, of members that cannot go

local function class_of(self)
    local class = rawget(self, "__class")
    if not class then
        class = call(self, "getStringProperty", "objectType")
        rawset(self, "__class", class)
    end
    return class
end

local function type_of(self, name)
    local members = known[class_of(self)]
    if not members then
        members = {}
        known[class_of(self)] = members
    end
    if members[name] then return members[name] end
    local kind, flags = call(self, "getPropertyInfo", name, SILENT)
    if kind and flags & 4 == 0 then members[name] = kind end
    return kind
end

-- Methods of this module, which need the script's own functions.

local extra = { app = {}, detachedScript = {} }

function extra.app.throttle(_, action, interval, options)
    api_1.throttle(interval, action, table.unpack(options and options.args or {}))
end

function extra.detachedScript.getFunctions(self)
    return setmetatable({}, { __index = function(_, name)
        return function(_, argument) return self:callFunction(name, argument) end
    end })
end

function extra.detachedScript.registerFunctionHook(_, name, hook, before)
    api_1.registerScriptFuncHook(name, hook, before ~= false)
end

function extra.detachedScript.removeFunctionHook(_, name)
    error("hooks of '" .. tostring(name) .. "' stay until the script ends", 2)
end

local methods = {}                                              -- functions by name: the object is an argument

local function method(name)
    local found = methods[name]
    if not found then
        found = function(target, ...) return call(target, name, ...) end
        methods[name] = found
    end
    return found
end

local function member(owner, full)
    local own = extra[class_of(owner)]
    if own and own[full] then return own[full] end
    local kind = type_of(owner, full)
    if kind == nil then return nil end
    if kind == METHOD then return method(full) end
    if kind == GROUP then return setmetatable({ __owner = owner, __prefix = full .. "." }, PropertyGroup) end
    return (call(owner, "getProperty", full, { type = kind }))
end

local MADE = "^(%a+)%."
local FREE = { customData = true, signal = true, refs = true, origRefs = true, namedParam = true }

local function assign(owner, full, value)
    local free = FREE[full:match(MADE)]
    if value == nil and free then
        call(owner, "removeProperty", full)
        return
    end
    if free then
        call(owner, "setProperty", full, value)
    else
        call(owner, "setProperty", full, value, { type = type_of(owner, full) })
    end
end

function Object:__index(name)
    if type(name) ~= "string" then return nil end
    if name == "isValid" then return method(name) end           -- also of an object that was removed
    return member(self, name)
end

function Object:__newindex(name, value) assign(self, name, value) end
function Object.__eq(a, b) return rawget(a, "__handle") == rawget(b, "__handle") end
function Object:__tostring() return "sim.Object(" .. rawget(self, "__handle") .. ")" end

setmetatable(Object, { __call = function(_, value)
    if getmetatable(value) == Object then return value end
    if type(value) == "string" then return sim.scene:getObject(value) end
    assert(math.type(value) == "integer", "sim.Object is made of a handle or a path")
    return object(value)
end })

function Object.isobject(_, value) return getmetatable(value) == Object end

function PropertyGroup:__index(name)
    if type(name) ~= "string" then return nil end
    return member(rawget(self, "__owner"), rawget(self, "__prefix") .. name)
end

function PropertyGroup:__newindex(name, value)
    assign(rawget(self, "__owner"), rawget(self, "__prefix") .. name, value)
end

function PropertyGroup:__tostring()
    return tostring(rawget(self, "__owner")) .. "." .. rawget(self, "__prefix"):sub(1, -2)
end

-- The names and values of a group.
function PropertyGroup:__pairs()
    local owner, prefix, place = rawget(self, "__owner"), rawget(self, "__prefix"), -1
    return function()
        place = place + 1
        local name = call(owner, "getPropertyName", place, { prefix = prefix })
        if name == nil then return nil end
        return name:sub(#prefix + 1), call(owner, "getProperty", name, SILENT)
    end
end

setmetatable(ObjectArray, { __call = function(_, values)
    local found = {}
    for i, value in ipairs(values or {}) do found[i] = Object(value) end
    return found
end })

-- The module.

sim.callMethod = call
sim.app, sim.scene = object(APP), object(SCENE)
sim.self = object((invoke(SELF, "getLongProperty", "handle")))

for name, value in next, api_1 do
    if type(value) ~= "function" and sim[name] == nil then sim[name] = value end
end
sim.propertytype_color3, sim.propertytype_color = 10, 26
sim.propertytype_object, sim.propertytype_objectarray, sim.propertytype_objectmap = 224, 225, 226

if rawget(_G, "_S") == nil then _S = {} end                     -- a table that the delivered scripts keep state in

-- Arguments of a call-back: a joint is an object.
function sim.__arguments(first, ...)
    if type(first) == "table" and rawget(first, "handle") and rawget(first, "mode") and not rawget(first, "joint") then
        first.joint = object(first.handle)
    end
    return decode(first), ...
end

-- Functions of API 1, which the first versions of this module had too, and enumerations, such as
-- sim.simulationState.running, which are read when they are used.
local enumerations
setmetatable(sim, { __index = function(_, name)
    if type(name) ~= "string" then return nil end
    local old = rawget(api_1, name)
    if old ~= nil then return old end
    if not enumerations then
        enumerations = {}
        for _, each in ipairs(call(APP, "getStringArrayProperty", "enumTypes")) do enumerations[each] = true end
    end
    if not enumerations[name] then return nil end
    local items = call(APP, "getEnumInfo", name)
    rawset(sim, name, items)
    return items
end })

return sim
