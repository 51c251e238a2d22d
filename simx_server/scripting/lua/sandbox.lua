-- The trusted Lua chunk that builds a script's world and guards every entry into it.
--
-- It and its parts, the other Lua files in this folder, are the only Lua code that has access to Lua's `debug`
-- and to Python objects; both stay upvalues, which a script's own `debug` cannot read. Reasons for each guard:
--
-- * a hook stops endless loops, see `watch.lua`; the way out (`enter`, `report`) is excluded, or the error
--   would leave with the hook still set;
-- * a message handler runs inside the hook, where no hook runs: `xpcall` calls it after the unwinding, see
--   `debug.lua`;
-- * finalizers run with hooks off, so `__gc` is refused;
-- * binary chunks can crash the virtual machine, so `load` accepts text only, of limited length;
-- * Python reads tables raw, with lupa's `items`: reading must not run a script's metamethods;
-- * the functions of Python never raise (`interpreter.py`): lupa would pass the exception to the script as an
--   object;
-- * no hook runs within one call of a C function: `library.lua`, which gets the script's world before any
--   script does, limits the slow functions of the standard library.
--
-- Threads: `depth` counts nested calls from Python, `level` the coroutines: 0 outside of any, 1 in one that
-- was resumed from there (the server's thread among them), more in a script's coroutine within a coroutine. A
-- coroutine that switched within a loop (`turns.py`) yields `SWITCH`, which only `resume` sees. The first
-- result of a function of the API is its status: true, the shape of flat results (`crossing/flat.py`), false (an
-- error), `switch` (done, but switch to others first) or `wait` (call again after the next resumption).

local late, function_of, proceed, output, module, with_turns, is_tired, refuse, phases, tell_lacking, max_depth, spaces,
    find_member, all_members, old_spaces, parts, to_python, count_calls = ...

-- A script cannot read the metatable of a Python object, should one get out.
debug.getmetatable(late).__metatable = false

local coresume, yield, isyieldable, costatus =
    coroutine.resume, coroutine.yield, coroutine.isyieldable, coroutine.status
local error, pcall, type, select, tostring, load, next = error, pcall, type, select, tostring, load, next
local rawget, rawlen, rawset, setmetatable, pairs = rawget, rawlen, rawset, setmetatable, pairs
local pack, unpack, find, gmatch, gsub, match, lower, rawequal = table.pack, table.unpack, string.find, string.gmatch,
    string.gsub, string.match, string.lower, rawequal
local mathtype = math.type
local getinfo, upvaluename, join = debug.getinfo, debug.getupvalue, debug.upvaluejoin

local depth, level, report, enter = 0, 0, nil, nil

local function part(name) return load(parts[name], "=sandbox", "b") end

local watching = part("watch")(late)
local where, look, begin, arm, disarm =
    watching.where, watching.look, watching.begin, watching.arm, watching.disarm

local values = part("values")(where, max_depth, to_python)
local plain_all, leaving, builders = values.plain_all, values.leaving, values.builders

local function finish(status, ...)
    if status == true then return ... end
    local build = builders[status]
    if build then return build(...) end
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

local replace_string                                            -- see `values.lua`

-- Functions that Lua calculates itself outside of coroutines, where the time of calls does not count. Python is told
-- of these calls before the next one of its own, and before the script returns: recordings count all calls.
local arithmetic, untold = part("arithmetic")(), 0

local function tell_calls()
    local count = untold
    untold = 0
    count_calls(count)
end

-- A function of the API: Python's is made at the first call. Most arguments are one or two numbers.
local function bind(bound_name)
    local action
    local function call(...)
        if untold > 0 then tell_calls() end
        if not action then action = function_of(bound_name) end
        local at, count, first, second = level > 0 and isyieldable() and level or 0, select("#", ...), ...
        if count == 0 or mathtype(first) and (count == 1 or count == 2 and mathtype(second)) then
            return finish(action(at, nil, ...))
        end
        return finish(action(at, leaving(...)))
    end
    local calculate = arithmetic[bound_name]
    if calculate then
        return function(...)
            local found = level == 0 and calculate(...)
            if not found then return call(...) end
            untold = untold + 1
            return found
        end
    end
    if bound_name ~= "sim.transformImage" then return call end
    return function(image, ...)
        local changed = call(image, ...)
        replace_string(image, changed, bound_name)
        return changed
    end
end

-- Members of the API's namespaces are made when the script uses them: making all of them takes longer than most
-- scripts. Lists of them are complete: whatever reads a namespace without its metatable calls `complete` before.
local space_of = {}                                             -- the table of a namespace: its name

local function member(members, name)
    local value = rawget(members, name)
    local space = value == nil and type(name) == "string" and space_of[members]
    if not space then return value end
    local is_function, constant = find_member(space, name)
    if is_function then constant = bind(space .. "." .. name) end
    rawset(members, name, constant)
    return constant
end

local is_complete = false

local function complete()
    if is_complete then return end
    local all = load(all_members(), "=sandbox", "b")(bind)
    for members, space in next, space_of do
        for name, value in next, all[space] do
            if rawget(members, name) == nil then rawset(members, name, value) end
        end
    end
    is_complete = true
end

local function complete_pairs(members)
    complete()
    return next, members, nil
end

local world = {
    assert = assert, error = error, getmetatable = getmetatable, ipairs = ipairs,
    next = next, pairs = pairs, rawequal = rawequal, rawget = rawget, rawlen = rawlen, rawset = rawset,
    select = select, tonumber = tonumber, tostring = tostring, type = type, unpack = unpack, _VERSION = _VERSION,
}
world._G = world
replace_string = values.replacing(world)

function world.setmetatable(object, meta)
    if type(meta) == "table" and rawget(meta, "__gc") ~= nil then error("finalizers (__gc) are not available", 2) end
    return setmetatable(object, meta)
end

local show = part("text")(world, output, max_depth, look, function(value)
    if space_of[value] then complete() end
end)
local own = {}
local debugging = part("debug")(world, own, where, look, function(action) return action == enter end)
local complain, is_main = debugging.complain, debugging.is_main

-- Iterations of loops, see turns.py: after each SLICE of them Python decides whether the thread switches.
local SLICE <const>, SWITCH = 1000, {}
local turns_left, turns_done = SLICE, 0

local function turn()
    turns_left, turns_done = SLICE, turns_done + SLICE
    if level > 0 and isyieldable() and is_tired(turns_done) then yield(SWITCH) end
end

local function counters() return turns_left, turn end

-- A chunk of a script with counted iterations and the counters that all its chunks share.
local function compile(source, name, environment)
    local reason = refuse(source)
    if reason then return nil, reason end
    local chunk, problem = load(source, name, "t", environment)
    look(#source)
    if find(source, "next", 1, true) or find(source, "rawget", 1, true) then complete() end
    local counted = chunk and with_turns(source)
    local maker = counted and load(counted, name, "t", environment)
    if not chunk then return nil, problem end
    chunk = maker and maker() or chunk                              -- no loops, or too many upvalues for the counter
    is_main(chunk)
    for i = 1, 255 do
        local upvalue = upvaluename(chunk, i)
        if not upvalue then break end
        local which = upvalue == "simx_left" and 1 or upvalue == "simx_turn" and 2
        if which then join(chunk, i, counters, which) end
    end
    return chunk
end

-- A coroutine that switched in a loop returns immediately where it cannot wait: within another coroutine that
-- one switches too, and where that is impossible (in a comparison of table.sort) it continues. So does a
-- generator outside any coroutine (`through`): the script waits for its value.
local resume
local generators = setmetatable({}, { __mode = "k" })           -- coroutines that have yielded a value

local function left(thread, through, ok, ...)
    level = level - 1
    if rawequal((...), SWITCH) then
        if level == 0 and not through then return ok end
        if isyieldable() then yield(SWITCH) end
        return resume(thread, through)
    end
    if select("#", ...) > 0 then generators[thread] = true end
    return ok, ...
end

function resume(thread, through, ...)
    if level == 0 then turns_left, turns_done = SLICE, 0 end
    level = level + 1
    watching.quicken(thread)
    return left(thread, through, coresume(thread, ...))
end

local function through(ok, ...)
    if ok then return ... end
    error((...), 0)
end

-- As above, with the place of the call in front, as in Lua's own.
local function wrapped(ok, ...)
    if ok then return ... end
    local problem, caller = (...), getinfo(2, "Sl")
    if type(problem) == "string" and caller.source ~= "=sandbox" and caller.currentline > 0 then
        problem = caller.short_src .. ":" .. caller.currentline .. ": " .. problem
    end
    error(problem, 0)
end

local function expect(kind, value, name)
    if type(value) ~= kind then
        complain(1, name, kind .. " expected, got " .. type(value))
    end
    return value
end

world.coroutine = {}
for key, value in pairs(coroutine) do world.coroutine[key] = value end
function world.coroutine.create(body) return watching.create(expect("function", body, "create")) end
function world.coroutine.close(thread) return watching.close(expect("thread", thread, "close")) end
function world.coroutine.resume(thread, ...)
    return resume(expect("thread", thread, "resume"), generators[thread], ...)
end
function world.coroutine.wrap(body)
    local thread = watching.create(expect("function", body, "wrap"))
    return function(...) return wrapped(resume(thread, true, ...)) end
end

part("library")(world, where, look, compile, part("old")())
local load_text = world.load                                    -- a script may replace it
part("patterns")(world, look)

-- V-REP's scripts add folders to package.path; modules come from beside the scene whatever it is.
local of_simulator = function() end                             -- see simulator.lua
local loaded = {}
world.package = { path = "./?.lua", cpath = "", config = "/\n;\n?\n!\n-\n", loaded = loaded, preload = {} }
for i = 1, #spaces do
    local space, members = spaces[i], {}
    space_of[members] = space
    world[space] = setmetatable(members, {
        __index = function(_, name)
            local found = member(members, name)
            if found ~= nil then return found end
            found = space == "sim" and of_simulator(name, "sim")
            if found then return found end
            return finish(function_of(space .. "." .. tostring(name))(0, nil))
        end,
        __pairs = complete_pairs,
        __metatable = false,
    })
    loaded[space] = members
end

part("files")(world, where, output, member)

-- V-REP's only function that overwrites its table argument: values pass the interface as copies, so it is done
-- here.
local inverse = world.sim and member(world.sim, "invertMatrix")
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
        local found = of_simulator(name)
        if found ~= nil then return found end
        local constant = match(name, "^sim_(.+)$") or match(name, "^sim(rml_.+)$")
        if constant then return member(world.sim, constant) end
        local motion = match(name, "^simRML(.+)$")
        if motion then return member(world.sim, "rml" .. motion) end
        for prefix, space in next, old_spaces do
            local rest = match(name, "^sim" .. prefix .. "(.+)$")
            local found = rest and world[space] and member(world[space], rest)
            if found ~= nil then return found end
        end
        local first, rest = match(name, "^sim(%u)(.*)$")
        if first then return member(world.sim, lower(first) .. rest) end
        return nil
    end,
})

function world.require(name)
    if type(name) == "string" and #name > 1000 then error("require: the name of a module is too long", 2) end
    if name ~= "sim-2" and name ~= "simIK-2" then                       -- a version, as in "sim-1"
        name = match(tostring(name), "^(sim%w*)%-%d$") or tostring(name)
    end
    name = gsub(name, "^[/\\]lua[/\\]", "")                               -- V-REP's folder of modules
    if loaded[name] == nil then
        local source = finish(module(name))
        local chunk, problem = compile(source, "@" .. name .. ".lua", world)
        if not chunk then error(problem, 0) end
        local value = through(pcall(chunk, name))
        loaded[name] = value == nil and true or value
    end
    return loaded[name]
end

local main_text = ""

-- Whether the script assigns a variable of this name, a global one or a local one.
local function assigns(name)
    look(#main_text)
    return find(main_text, "%f[%w_]" .. name .. "%s*=[^=]") or find(main_text, "function%s+" .. name .. "%s*%(")
end

of_simulator = part("simulator")(world, assigns)

-- A chunk from a file, as a module is found: only beside the scene, whatever folder the path names.
function world.loadfile(path)
    local name = gsub(match(tostring(path), "([^/\\]*)$"), "%.lua$", "")
    local ok, found, source = pcall(module, name)
    if not ok or not found then return nil, "cannot open " .. tostring(path) .. ": it is not beside the scene" end
    return compile(source, "@" .. name .. ".lua", world)
end

function world.dofile(path)
    local chunk, problem = world.loadfile(path)
    if not chunk then error(problem, 2) end
    return chunk()
end

-- V-REP 3.6's form of require, with the file's path in the simulator's folder, and a text that runs before.
if world.sim and member(world.sim, "include") then
    function world.sim.include(file, command)
        local before, problem = compile(tostring(command or ""), "=(include)", world)
        if not before then error(problem, 2) end
        before()
        local name = gsub(gsub(tostring(file), "^[/\\\\]?lua[/\\\\]", ""), "%.lua$", "")
        return world.require((gsub(name, "[/\\\\]", ".")))
    end
end

-- Functions that the script's functions called from outside are to call before or after themselves, by name.
local hooks = {}

-- The call-backs of simulation steps as they were at the last look at them; false: unknown.
local seen = {}
for i = 1, #phases do seen[i] = false end

local function hooked(name, action)
    local mine = hooks[name]
    if not mine then return action end
    return function(...)
        for i = 1, #mine.before do mine.before[i](...) end
        local results = action and pack(action(...)) or pack()
        for i = 1, #mine.after do mine.after[i](...) end
        return unpack(results, 1, results.n)
    end
end

if world.sim and member(world.sim, "registerScriptFuncHook") then
    function world.sim.registerScriptFuncHook(name, hook, is_before)
        local action = type(hook) == "string" and world[hook] or hook
        if type(action) ~= "function" then error("sim.registerScriptFuncHook: argument 2 must be a function", 2) end
        local mine = hooks[tostring(name)] or { before = {}, after = {} }
        hooks[tostring(name)] = mine
        local list = is_before and mine.before or mine.after
        list[#list + 1] = action
        for i = 1, #phases do seen[i] = false end
        return #list
    end
end

-- Functions of the API are known by their upvalue, see name_of; these are written above.
own.sim = world.sim and {
    invertMatrix = member(world.sim, "invertMatrix"),
    include = member(world.sim, "include"),
    registerScriptFuncHook = member(world.sim, "registerScriptFuncHook"),
}
for name, value in next, world do
    if loaded[name] then                                            -- a namespace of the API
    elseif type(value) == "table" and value ~= world then
        own[name] = {}
        for key, member in next, value do own[name][key] = member end
    elseif type(value) == "function" then
        own[name] = value
    end
end

-- Python is told when other call-backs of simulation steps exist than before: it does not call those that are
-- lacking. The number has a bit for each of them.
local lacking = 0

local function look_for_phases()
    local is_known = true
    for i = 1, #phases do
        local action = rawget(world, phases[i])
        if not rawequal(action, seen[i]) then seen[i], is_known = action, false end
    end
    if is_known then return end
    local found = 0
    for i = 1, #phases do
        if type(seen[i]) ~= "function" and not hooks[phases[i]] then found = found | 1 << (i - 1) end
    end
    if found ~= lacking then
        lacking = found
        tell_lacking(found)
    end
end

function report(ok, ...)
    if untold > 0 then tell_calls() end
    depth = depth - 1
    if depth == 0 then
        disarm()
        look_for_phases()
    end
    return ok, ...
end

-- An error leaves as text.
local function told(problem)
    if type(problem) == "string" then return problem end
    local ok, text = pcall(show, problem)
    return "raised a " .. type(problem) .. " value" .. (ok and ": " .. text or "")
end

local function guarded(finally, ok, ...)
    if not ok then return false, told((...)) end
    if finally and select("#", ...) > 0 then return pcall(finally, ...) end
    return true, ...
end

-- A C function calls `action`: a level of error() that means its caller names no place.
function enter(finally, action, ...)
    if depth == 0 then
        level = 0
        begin()
    else
        arm()
    end
    depth = depth + 1
    return report(guarded(finally, pcall(action, ...)))
end

watching.spare(enter, guarded, told, report, begin, arm, disarm)

-- A call-back of a script that has required sim-2 gets objects.
local function with_objects(name, action)
    local api_2 = loaded["sim-2"]
    if not action or not api_2 or not find(name, "^sysCall_") then return action end
    local convert = rawget(api_2, "__arguments")
    return function(...) return action(convert(...)) end
end

local function find_action(name)
    if not find(name, ".", 1, true) then
        local action = rawget(world, name)
        return hooked(name, with_objects(name, type(action) == "function" and action or nil))
    end
    local value = world
    for part in gmatch(name, "[^.]+") do
        if type(value) ~= "table" then return nil end
        value = member(value, part)
    end
    return hooked(name, type(value) == "function" and value or nil)
end

local function apply(action, ...) return enter(plain_all, action, ...) end

local thread = nil

local face = {}

function face.run(source, name)
    main_text = source
    local chunk, problem = compile(source, name, world)
    if not chunk then return false, problem end
    return enter(nil, chunk)
end

-- Executes a text among the script's variables; what the text returns leaves the script.
function face.evaluate(source)
    return enter(plain_all, function()
        local chunk, problem = load_text(source)
        if not chunk then error(problem, 0) end
        return chunk()
    end)
end

function face.has(name) return find_action(name) ~= nil end

function face.call(name, ...)
    local action = find_action(name)
    if not action then return false, "has no function '" .. name .. "'" end
    return apply(action, ...)
end

-- As `call`, for a name without dots; nil where there is no such function.
function face.attempt(name, ...)
    local action = rawget(world, name)
    if type(action) ~= "function" then action = nil end
    if loaded["sim-2"] then action = with_objects(name, action) end
    if hooks[name] then action = hooked(name, action) end
    if not action then return nil end
    return enter(plain_all, action, ...)
end

face.apply = apply

-- V-REP ran the whole text of a threaded script in its thread, so it may wait anywhere. `mains`: its functions that
-- follow in the thread, at the next resumption.
function face.start_text(source, name, mains)
    main_text = source
    local chunk, problem = compile(source, name, world)
    if not chunk then return false, problem end
    thread = watching.create(function()
        chunk()
        for main in gmatch(mains, "%S+") do
            local action = find_action(main)
            if action then
                yield()
                return action()
            end
        end
    end)
    return true
end

function face.start_thread(name)
    local action = find_action(name)
    if not action then return false, "has no function '" .. name .. "'" end
    thread = watching.create(action)
    return true
end

function face.resume()
    if not thread or costatus(thread) ~= "suspended" then return true, false end
    return enter(nil, function()
        through(resume(thread, false))
        return costatus(thread) == "suspended"
    end)
end

return face
