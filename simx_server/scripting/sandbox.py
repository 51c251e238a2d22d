"""The trusted Lua chunk that builds a script's world and guards every entry into it.

With `lua_watch.py` it is the only Lua code that ever sees ``debug`` and Python objects; both stay upvalues, and without
``debug`` a script cannot read upvalues. Why each guard is needed:

* a hook stops endless loops, see `lua_watch.py`; the way out (``enter``, ``report``) is spared, or the error would
  leave with the hook still set;
* a message handler runs inside the hook, where no hook strikes: ``xpcall`` calls it after the unwinding;
* finalizers run with hooks off, so ``__gc`` is refused;
* binary chunks can crash the virtual machine, so ``load`` takes text only, and not too much at once;
* tables are copied raw before Python reads them: reading must not run a script's metamethods;
* no hook strikes within one call of a C function: those of the standard library that could take long by themselves
  are bounded by `lua_library.py`, which gets the script's world before any script does.

Threads: ``depth`` counts calls from Python that lie within each other, ``level`` the coroutines: 0 outside of any, 1 in
one that was resumed from there (the server's thread among them), more in a script's coroutine within a coroutine.
What a function of the API answers is told by its first result: true, false (an error), ``switch`` (done, but let others
go on first) or ``wait`` (ask again after the next resumption).
"""

GUARD = rb"""
local late, invoke, proceed, output, module, max_depth, known, watch, library = ...

local coresume, yield, isyieldable, costatus =
    coroutine.resume, coroutine.yield, coroutine.isyieldable, coroutine.status
local error, pcall, type, select, tostring, load, next = error, pcall, type, select, tostring, load, next
local rawget, rawlen, rawset, setmetatable, pairs = rawget, rawlen, rawset, setmetatable, pairs
local pack, unpack, concat, gmatch, match, lower, mathtype =
    table.pack, table.unpack, table.concat, string.gmatch, string.match, string.lower, math.type

local depth, level, report = 0, 0, nil

local watching = load(watch, "=sandbox", "t")(late)
local where, look = watching.where, watching.look

-- A table as the border knows it: keys are text or whole numbers.
local function plain(value, nesting)
    local kind = type(value)
    if kind == "thread" or kind == "userdata" then error(where() .. "a " .. kind .. " cannot leave the script", 0) end
    if kind ~= "table" then return value end
    if nesting > max_depth then error(where() .. "has a table nested too deeply, or within itself", 0) end
    local copy = {}
    for key, item in next, value do
        if type(key) ~= "string" and mathtype(key) ~= "integer" then
            local what = mathtype(key) and "number with a fraction" or type(key)
            error(where() .. "a table with a " .. what .. " as a key cannot leave the script; keys are text or whole "
                .. "numbers", 0)
        end
        copy[key] = plain(item, nesting + 1)
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

local function left(...)
    level = level - 1
    return ...
end

local function resume(thread, ...)
    level = level + 1
    watching.quicken(thread)
    return left(coresume(thread, ...))
end

local function through(ok, ...)
    if ok then return ... end
    error((...), 0)
end

world.coroutine = {}
for key, value in pairs(coroutine) do world.coroutine[key] = value end
world.coroutine.create, world.coroutine.close = watching.create, watching.close
world.coroutine.resume = resume
function world.coroutine.wrap(body)
    local thread = watching.create(body)
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
        return 1
    end
end

-- The old names: simGetObjectPosition, sim_handle_self; of V-REP's motion library simRMLPos, simrml_no_sync
setmetatable(world, {
    __index = function(_, name)
        if type(name) ~= "string" then return nil end
        local constant = match(name, "^sim_(.+)$") or match(name, "^sim(rml_.+)$")
        if constant then return rawget(world.sim, constant) end
        local motion = match(name, "^simRML(.+)$")
        if motion then return rawget(world.sim, "rml" .. motion) end
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
    if depth == 0 then watching.disarm() end
    if ok then return true, ... end
    local problem = ...
    if type(problem) == "string" then return false, problem end
    return false, "raised a " .. type(problem) .. " value"
end

local function enter(action, ...)
    if depth == 0 then
        level = 0
        watching.begin()
    end
    depth = depth + 1
    watching.arm()
    return report(pcall(action, ...))
end

watching.spare(enter, report, watching.arm, watching.disarm)

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
    thread = watching.create(action)
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
