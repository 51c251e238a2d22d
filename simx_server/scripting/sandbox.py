"""The trusted Lua chunk that builds a script's world and guards every entry into it.

It is the only Lua code that ever sees ``debug`` and Python objects; both stay upvalues here, and without
``debug`` a script cannot read upvalues. Why each guard is needed:

* the count hook stops endless loops. Once it has struck it strikes on every instruction, otherwise
  ``while true do pcall(busy) end`` would swallow it for ever;
* the way out (``enter``, ``report``) is spared, or the error would leave with the hook still set;
* coroutines have a hook of their own, so they are made here;
* a message handler runs inside the hook, where no hook strikes: ``xpcall`` calls it after the unwinding;
* finalizers run with hooks off, so ``__gc`` is refused;
* binary chunks can crash the virtual machine, so ``load`` takes text only;
* tables are copied raw before Python reads them: reading must not run a script's metamethods.

What it does not stop: one single call of the string library that takes for ever by itself (a pattern
made to backtrack), which no hook can interrupt.
"""

HOOK_INTERVAL = 10_000
"""Lua instructions between two looks at the clock: about 0.1 ms, and the look itself costs 1 us."""

GUARD = rb"""
local late, invoke, output, interval, known = ...

local sethook, getinfo, cocreate, coresume =
    debug.sethook, debug.getinfo, coroutine.create, coroutine.resume
local error, pcall, type, select, tostring, load = error, pcall, type, select, tostring, load
local rawget, rawlen, setmetatable, pairs = rawget, rawlen, setmetatable, pairs
local pack, unpack, concat, gmatch = table.pack, table.unpack, table.concat, string.gmatch

local struck, enter, report = false, nil, nil

-- "file:line: " of the innermost frame that is the script's own
local function where()
    for level = 2, 30 do
        local frame = getinfo(level, "Sl")
        if not frame then break end
        if frame.source ~= "=sandbox" and frame.currentline > 0 then
            return frame.short_src .. ":" .. frame.currentline .. ": "
        end
    end
    return ""
end

local function watch()
    if struck or late() then
        local running = getinfo(2, "f")
        if running and (running.func == enter or running.func == report) then return end
        struck = true
        sethook(watch, "", 1)
        error(where() .. "took too long and was stopped (an endless loop?)", 0)
    end
end

local function plain(value, depth)
    if type(value) ~= "table" then return value end
    if depth > 8 then error("has a table nested too deeply", 0) end
    local copy = {}
    for i = 1, rawlen(value) do copy[i] = plain(rawget(value, i), depth + 1) end
    return copy
end

local function finish(ok, ...)
    if ok then return ... end
    error(where() .. (...), 0)
end

local function bind(name)
    return function(...)
        local values = pack(...)
        for i = 1, values.n do values[i] = plain(values[i], 1) end
        return finish(invoke(name, unpack(values, 1, values.n)))
    end
end

local world = {
    assert = assert, collectgarbage = collectgarbage, error = error, getmetatable = getmetatable, ipairs = ipairs,
    next = next, pairs = pairs, pcall = pcall, rawequal = rawequal, rawget = rawget, rawlen = rawlen, rawset = rawset,
    select = select, tonumber = tonumber, tostring = tostring, type = type, unpack = unpack, _VERSION = _VERSION,
}
world._G = world

for _, library in pairs { "math", "string", "table", "utf8" } do
    world[library] = {}
    for key, value in pairs(_G[library]) do world[library][key] = value end
end
world.string.dump = nil
getmetatable("").__index = world.string
world.math.pow = function(x, y) return x ^ y end
world.table.getn = function(t) return #t end
world.math.randomseed(1)

function world.setmetatable(object, meta)
    if type(meta) == "table" and rawget(meta, "__gc") ~= nil then error("finalizers (__gc) are not available", 2) end
    return setmetatable(object, meta)
end

function world.load(chunk, name, _, environment)
    return load(chunk, name, "t", environment == nil and world or environment)
end
world.loadstring = world.load

function world.print(...)
    local texts = pack(...)
    for i = 1, texts.n do texts[i] = tostring(texts[i]) end
    output(concat(texts, "\t"))
end

local function handled(handle, ok, ...)
    if ok then return true, ... end
    return false, handle(...)
end

function world.xpcall(action, handle, ...)
    return handled(handle, pcall(action, ...))
end

local function create(body)
    local thread = cocreate(body)
    sethook(thread, watch, "", interval)
    return thread
end

local function through(thread, ok, ...)
    if ok then return ... end
    error((...), 0)
end

world.coroutine = {}
for key, value in pairs(coroutine) do world.coroutine[key] = value end
world.coroutine.create = create
function world.coroutine.wrap(body)
    local thread = create(body)
    return function(...) return through(thread, coresume(thread, ...)) end
end

local sim = {}
for name, constant in pairs(known) do
    if constant == false then sim[name] = bind(name) else sim[name] = constant end
end
world.sim = setmetatable(sim, {
    __index = function(_, name) return finish(invoke(tostring(name))) end,
    __metatable = false,
})

function report(ok, ...)
    sethook()
    struck = false
    if ok then return true, ... end
    local problem = ...
    if type(problem) == "string" then return false, problem end
    return false, "raised a " .. type(problem) .. " value"
end

function enter(action, ...)
    sethook(watch, "", interval)
    return report(pcall(action, ...))
end

local function run(source, name)
    local chunk, problem = load(source, name, "t", world)
    if not chunk then return false, problem end
    return enter(chunk)
end

local function find(name)
    local value = world
    for part in gmatch(name, "[^.]+") do
        if type(value) ~= "table" then return nil end
        value = rawget(value, part)
    end
    if type(value) == "function" then return value end
    return nil
end

local function gather(...)
    local values = pack(...)
    for i = 1, values.n do values[i] = plain(values[i], 1) end
    return unpack(values, 1, values.n)
end

local function call(name, ...)
    local action = find(name)
    if not action then return false, "has no function '" .. name .. "'" end
    return enter(function(...) return gather(action(...)) end, ...)
end

return run, call, function(name) return find(name) ~= nil end
"""
