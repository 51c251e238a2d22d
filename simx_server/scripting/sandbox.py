"""The trusted Lua chunk that builds a script's world and guards every entry into it.

It is the only Lua code that ever sees ``debug`` and Python objects; both stay upvalues here, and without
``debug`` a script cannot read upvalues. Why each guard is needed:

* the count hook stops endless loops. Once it has struck it strikes on every instruction, otherwise
  ``while true do pcall(busy) end`` would swallow it for ever;
* the way out (``enter``, ``report``) is spared, or the error would leave with the hook still set;
* coroutines have a hook of their own, so they are made here;
* a message handler runs inside the hook, where no hook strikes: ``xpcall`` calls it after the unwinding;
* finalizers run with hooks off, so ``__gc`` is refused;
* binary chunks can crash the virtual machine, so ``load`` takes text only, and not too much at once;
* tables are copied raw before Python reads them: reading must not run a script's metamethods;
* no hook strikes within one call of a C function: those of the standard library that could take long by themselves
  are bounded by `lua_library.py`, which gets the script's world before any script does;
* an instruction may copy a string as long as the heap is large, so the hook strikes the more often the longer the
  last ones took, and the larger the heap is.

Threads: ``depth`` counts calls from Python that lie within each other, ``level`` the coroutines: 0 outside of any, 1 in
one that was resumed from there (the server's thread among them), more in a script's coroutine within a coroutine.
What a function of the API answers is told by its first result: true, false (an error), ``switch`` (done, but let others
go on first) or ``wait`` (ask again after the next resumption).
"""

GUARD = rb"""
local late, invoke, proceed, output, module, max_depth, known, library = ...

local sethook, getinfo, cocreate, coresume, yield, isyieldable, costatus =
    debug.sethook, debug.getinfo, coroutine.create, coroutine.resume, coroutine.yield, coroutine.isyieldable,
    coroutine.status
local error, pcall, type, select, tostring, load, next = error, pcall, type, select, tostring, load, next
local rawget, rawlen, rawset, setmetatable, pairs = rawget, rawlen, rawset, setmetatable, pairs
local pack, unpack, concat, gmatch, match, lower =
    table.pack, table.unpack, table.concat, string.gmatch, string.match, string.lower

local clock, heap = os.clock, collectgarbage

local struck, depth, level, watch, enter, report = false, 0, 0, nil, nil, nil

-- "file:line: " of the innermost frame that is the script's own
local function where()
    for frame_level = 2, 30 do
        local frame = getinfo(frame_level, "Sl")
        if not frame then break end
        if frame.source ~= "=sandbox" and frame.currentline > 0 then
            return frame.short_src .. ":" .. frame.currentline .. ": "
        end
    end
    return ""
end

-- Instructions between two strikes of the hook: as many as take about 1 ms; of cheap ones 2000 are 0.02 ms.
local FIRST, LEAST = 200, 8
local interval, greatest, last_strike, last_look = FIRST, FIRST, 0, 0

-- A look at Python's clock, with others served, when the last one is a millisecond ago. True: the time is over.
local function must_stop()
    if clock() - last_look < 0.001 then return struck end
    struck = late() or struck
    local kilobytes = heap("count")
    greatest = kilobytes < 2000 and 2000 or kilobytes < 8000 and 400 or 150
    last_look = clock()
    return struck
end

local function stop()
    sethook(watch, "", 1)
    error(where() .. "took too long and was stopped (an endless loop?)", 0)
end

function watch()
    if not struck then
        local now = clock()
        local took = now - last_strike
        local wanted = took > 0.002 and interval // 8 or took < 0.0005 and interval * 2 or interval
        if wanted > greatest then wanted = greatest elseif wanted < LEAST then wanted = LEAST end
        if wanted ~= interval then
            interval = wanted
            sethook(watch, "", wanted)
        end
        last_strike = now
        if now - last_look < 0.001 then return end
    end
    if must_stop() then
        local running = getinfo(2, "f")
        if running and (running.func == enter or running.func == report) then return end
        stop()
    end
    last_strike = clock()
end

-- For the library, around what takes long without many instructions.
local function look()
    if must_stop() then stop() end
end

-- A table as the border knows it: a list, or else a map with keys of text or whole numbers.
local function plain(value, nesting)
    local kind = type(value)
    if kind == "thread" or kind == "userdata" then error(where() .. "a " .. kind .. " cannot leave the script", 0) end
    if kind ~= "table" then return value end
    if nesting > max_depth then error(where() .. "has a table nested too deeply, or within itself", 0) end
    local copy = {}
    local length = rawlen(value)
    if length > 0 then
        for i = 1, length do copy[i] = plain(rawget(value, i), nesting + 1) end
        return copy
    end
    for key, item in next, value do
        if type(key) == "string" or math.type(key) == "integer" then copy[key] = plain(item, nesting + 1) end
    end
    return copy
end

local function plain_all(...)
    local values = pack(...)
    for i = 1, values.n do values[i] = plain(values[i], 1) end
    return unpack(values, 1, values.n)
end

local function finish(status, ...)
    if status == true then return ... end
    if status == "switch" then
        yield()
        return ...
    end
    if status == "wait" then
        yield()
        return finish(proceed(...))
    end
    error(where() .. (...), 0)
end

local function bind(name)
    return function(...)
        return finish(invoke(isyieldable() and level or 0, name, plain_all(...)))
    end
end

local world = {
    assert = assert, collectgarbage = collectgarbage, error = error, getmetatable = getmetatable, ipairs = ipairs,
    next = next, pairs = pairs, rawequal = rawequal, rawget = rawget, rawlen = rawlen, rawset = rawset,
    select = select, tonumber = tonumber, tostring = tostring, type = type, unpack = unpack, _VERSION = _VERSION,
}
world._G = world

function world.setmetatable(object, meta)
    if type(meta) == "table" and rawget(meta, "__gc") ~= nil then error("finalizers (__gc) are not available", 2) end
    return setmetatable(object, meta)
end

function world.print(...)
    local texts = pack(...)
    for i = 1, texts.n do texts[i] = tostring(texts[i]) end
    output(concat(texts, "\t"))
end

-- A memory error comes after few instructions and much time, so each error is followed by a look.
local function handled(handle, ok, ...)
    if ok then return true, ... end
    look()
    if handle then return false, handle(...) end
    return false, ...
end

function world.pcall(action, ...)
    return handled(nil, pcall(action, ...))
end

function world.xpcall(action, handle, ...)
    return handled(handle, pcall(action, ...))
end

world.debug = {}
function world.debug.traceback(message) return message end

-- What each coroutine's hook is set to. It is not set anew without need: that would begin its count again.
local spans = setmetatable({}, { __mode = "k" })

local function create(body)
    local thread = cocreate(body)
    spans[thread] = interval
    sethook(thread, watch, "", interval)
    return thread
end

local function left(...)
    level = level - 1
    return ...
end

local function resume(thread, ...)
    level = level + 1
    if spans[thread] and spans[thread] > interval then
        spans[thread] = interval
        sethook(thread, watch, "", interval)
    end
    return left(coresume(thread, ...))
end

local function through(ok, ...)
    if ok then return ... end
    error((...), 0)
end

world.coroutine = {}
for key, value in pairs(coroutine) do world.coroutine[key] = value end
world.coroutine.create = create
world.coroutine.resume = resume
function world.coroutine.wrap(body)
    local thread = create(body)
    return function(...) return through(resume(thread, ...)) end
end

load(library, "=sandbox", "t")(world, where, look)

local loaded = {}
for space, names in pairs(known) do
    local members = {}
    for name, constant in pairs(names) do
        if constant == false then members[name] = bind(space .. "." .. name) else members[name] = constant end
    end
    world[space] = setmetatable(members, {
        __index = function(_, name) return finish(invoke(0, space .. "." .. tostring(name))) end,
        __metatable = false,
    })
    loaded[space] = members
end

-- V-REP's one function that overwrites a table it is given: values cross the border as copies, so it is done here.
local inverse = world.sim and rawget(world.sim, "invertMatrix")
if inverse then
    function world.sim.invertMatrix(matrix)
        local found = inverse(matrix)
        for i = 1, #found do rawset(matrix, i, found[i]) end
        return matrix
    end
end

-- The old names: simGetObjectPosition, sim_handle_self
setmetatable(world, {
    __index = function(_, name)
        if type(name) ~= "string" then return nil end
        local constant = match(name, "^sim_(.+)$")
        if constant then return rawget(world.sim, constant) end
        local first, rest = match(name, "^sim(%u)(.*)$")
        if first then return rawget(world.sim, lower(first) .. rest) end
        return nil
    end,
})

function world.require(name)
    name = match(tostring(name), "^(sim%w*)%-%d$") or tostring(name)        -- a version, as in "sim-1"
    if loaded[name] == nil then
        local source = finish(module(name))
        local chunk, problem = load(source, "@" .. name .. ".lua", "t", world)
        if not chunk then error(problem, 0) end
        local value = chunk(name)
        loaded[name] = value == nil and true or value
    end
    return loaded[name]
end

function report(ok, ...)
    depth = depth - 1
    if depth == 0 then
        sethook()
        struck = false
    end
    if ok then return true, ... end
    local problem = ...
    if type(problem) == "string" then return false, problem end
    return false, "raised a " .. type(problem) .. " value"
end

function enter(action, ...)
    if depth == 0 then level, interval, last_strike, last_look = 0, FIRST, clock(), clock() end
    depth = depth + 1
    sethook(watch, "", struck and 1 or interval)
    return report(pcall(action, ...))
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

local function apply(action, ...)
    return enter(function(...) return plain_all(action(...)) end, ...)
end

local thread = nil

local face = {}

function face.run(source, name)
    local chunk, problem = load(source, name, "t", world)
    if not chunk then return false, problem end
    return enter(chunk)
end

function face.has(name) return find(name) ~= nil end

function face.call(name, ...)
    local action = find(name)
    if not action then return false, "has no function '" .. name .. "'" end
    return apply(action, ...)
end

face.apply = apply

function face.start_thread(name)
    local action = find(name)
    if not action then return false, "has no function '" .. name .. "'" end
    thread = create(action)
    return true
end

function face.resume()
    if not thread or costatus(thread) ~= "suspended" then return true, false end
    return enter(function()
        through(resume(thread))
        return costatus(thread) == "suspended"
    end)
end

return face
"""
