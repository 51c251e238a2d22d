-- Lua's standard library for scripts: without a single call that takes long; `files.lua` has the files.
--
-- No hook runs within a C function. So functions that take more than linear time, or linear time on huge
-- values, are written in Lua here: the hook checks the clock in them, and the server answers other clients.
-- The limits keep a C function below about 0.05 s.
-- Arguments: the script's world, a function that returns the script's position, the hook's check of the clock,
-- the compiler of chunks, what old Lua accepted.

local world, where, look, compile, old = ...
local error, type, pairs, pcall, select, tostring, tonumber = error, type, pairs, pcall, select, tostring, tonumber
local sort, concat, rep, unpack, move, insert, remove, match, metatable =
    table.sort, table.concat, string.rep, table.unpack, table.move, table.insert, table.remove, string.match,
    debug.getmetatable
local whole, whole_values = old.whole, old.whole_values
local format, find, sub, byte, gmatch, collect, getinfo, mathtype = string.format, string.find, string.sub,
    string.byte, string.gmatch, collectgarbage, debug.getinfo, math.type

local LONG_LIST, LONG_CHUNK, LONG_REPEAT, LONG_FORMAT, MANY, LONG_KEY = 10000, 200000, 16000000, 1000, 1000, 1000

-- An error of a C function is reported with the script's line, not with one of this file.
local function finish(ok, ...)
    if ok then return ... end
    local problem = ...
    if type(problem) ~= "string" then error(problem, 0) end
    local number, name, rest = match(problem, "^bad argument #(%d+) to '%w+%.(%w+)'(.*)$")
    if number then                                              -- with the numbers and names of Lua's own calls
        if not getinfo(1, "t").istailcall and getinfo(2, "n").namewhat == "method" then number = number - 1 end
        problem = "bad argument #" .. number .. " to '" .. name .. "'" .. rest
    end
    if not match(problem, "^[^\n]-:%d+: ") then problem = where() .. problem end
    error(problem, 0)
end

for _, library in pairs { "math", "string", "table", "utf8" } do
    world[library] = {}
    for key, value in pairs(_G[library]) do world[library][key] = value end
end
world.string.dump = nil
getmetatable("").__index = world.string
world.math.mod = math.fmod
world.math.pow = function(x, y) return x ^ y end
world.math.ldexp = function(x, e) return x * 2.0 ^ e end
world.math.log10 = function(x) return math.log(x, 10) end
world.math.atan2 = math.atan
world.math.cosh = function(x) return (math.exp(x) + math.exp(-x)) / 2 end
world.math.sinh = function(x) return (math.exp(x) - math.exp(-x)) / 2 end
world.math.tanh = function(x) return 1 - 2 / (math.exp(2 * x) + 1) end
world.math.frexp = function(x)
    if x == 0 or x - x ~= 0 then return x, 0 end
    local exponent = math.floor(math.log(math.abs(x), 2)) + 1
    local fraction = x / 2.0 ^ exponent
    if math.abs(fraction) >= 1 then return fraction / 2, exponent + 1 end
    if math.abs(fraction) < 0.5 then return fraction * 2, exponent - 1 end
    return fraction, exponent
end
world.table.getn = function(t) return #t end
world.table.foreach = function(t, action)
    for key, value in pairs(t) do
        local found = action(key, value)
        if found ~= nil then return found end
    end
end
world.table.foreachi = function(t, action)
    for i = 1, #t do
        local found = action(i, t[i])
        if found ~= nil then return found end
    end
end
world.table.maxn = function(t)
    local greatest = 0
    for key in pairs(t) do
        if type(key) == "number" and key > greatest then greatest = key end
    end
    return greatest
end
local seed, tointeger = world.math.randomseed, world.math.tointeger
seed(1)
-- Lua 5.1 takes numbers with fractions, such as sim.getFloatParam(sim.floatparam_rand) * 10000.
function world.math.randomseed(number, ...)
    if mathtype(number) == "float" and number - number == 0 then number = tointeger(number // 1) or 0 end
    return finish(pcall(seed, number, ...))
end

local random = world.math.random
function world.math.random(low, high)
    if low == nil then return random() end
    if mathtype(low) == "integer" and mathtype(high) == "integer" and low <= high then return random(low, high) end
    if high == nil then return finish(pcall(random, whole(low))) end
    return finish(pcall(random, whole(low), whole(high)))
end

function world.string.sub(text, first, last)
    if mathtype(first) == "integer" and (last == nil or mathtype(last) == "integer") and type(text) == "string" then
        return sub(text, first, last)
    end
    if mathtype(first) == "float" then first = whole(first) end
    if mathtype(last) == "float" then last = whole(last) end
    return finish(pcall(sub, text, first, last))
end

-- Programs and the environment do not exist for a script.
world.os = {
    clock = os.clock, difftime = os.difftime, time = os.time,
    getenv = function() return nil end,
    setlocale = function() return "C" end,
    execute = function(command)
        if command == nil then return false end
        return nil, "exit", 1
    end,
}
for _, name in pairs { "remove", "rename" } do
    world.os[name] = function(file) return nil, tostring(file) .. ": scripts change no files of the system", 1 end
end
function world.gcinfo() return collect("count") // 1 end
function world.getfenv() return world end

local date = os.date
function world.os.date(...)
    local pattern = ...
    if type(pattern) == "string" and #pattern > LONG_FORMAT then
        error(where() .. "os.date: a format of more than " .. LONG_FORMAT .. " bytes", 0)
    end
    return finish(pcall(date, ...))
end

-- The collector's settings are fixed, so that the memory use of a script is noticed (`watch.lua`).
local TUNED = {
    stop = 0, restart = 0, isrunning = true, setpause = 200, setstepmul = 100, incremental = "incremental",
    generational = "incremental",
}
function world.collectgarbage(option, ...)
    if TUNED[option] ~= nil then return TUNED[option] end
    if option == "count" then return collect("count") end
    look()
    if option == "step" then return finish(pcall(collect, "step")) end
    return finish(pcall(collect, option, ...))
end

-- The text that a function returns in pieces, until it returns none.
local function gather(reader)
    local pieces, size = {}, 0
    repeat
        local piece = reader()
        if piece ~= nil and type(piece) ~= "string" then error(where() .. "reader function must return a string", 0) end
        pieces[#pieces + 1] = piece
        size = size + #(piece or "")
    until piece == nil or piece == "" or size > LONG_CHUNK
    return concat(pieces)
end

function world.load(chunk, name, _, environment)
    if type(chunk) == "function" then
        local ok, text = pcall(gather, chunk)
        if not ok then return nil, text end
        chunk, name = text, name == nil and "=(load)" or name
    elseif type(chunk) ~= "string" then
        error(where() .. "bad argument #1 to 'load' (function expected, got " .. type(chunk) .. ")", 0)
    end
    if #chunk > LONG_CHUNK then return nil, "a chunk of more than " .. LONG_CHUNK .. " bytes cannot be loaded" end
    look()
    return compile(chunk, name == nil and chunk or name, environment == nil and world or environment)
end
world.loadstring = world.load

local function before(a, b) return a < b end

-- The hook cannot see a comparison in C, and with a metatable a list may be longer than it reports.
function world.table.sort(list, comes_before)
    local is_long = type(list) == "table" and (metatable(list) or #list > LONG_LIST)
    if type(list) == "table" and not is_long and comes_before == nil then
        for i = 1, #list do
            local value = list[i]
            if type(value) == "string" and #value > LONG_KEY then
                is_long = true
                look(#value)
                break
            end
        end
    end
    if is_long then
        local given = comes_before
        comes_before = type(given) == "function" and function(a, b) return given(a, b) end or given or before
    end
    return finish(pcall(sort, list, comes_before))
end

function world.table.concat(list, separator, first, last)
    if type(list) ~= "table" then return finish(pcall(concat, list)) end
    first, last = tonumber(first) or 1, tonumber(last) or #list
    if last - (first + 0.0) < LONG_LIST then return finish(pcall(concat, list, separator, first, last)) end
    local parts = {}
    for start = first, last, LONG_LIST do
        local stop = start + LONG_LIST - 1
        parts[#parts + 1] = finish(pcall(concat, list, separator, start, stop < last and stop or last))
        look()
    end
    return finish(pcall(concat, parts, separator))
end

-- As long as lists are, or report to be: piece by piece, the last one first where it would be overwritten.
function world.table.move(list, first, last, to, other)
    local from, stop, goal = tonumber(first), tonumber(last), tonumber(to)
    if not (from and stop and goal) or stop - (from + 0.0) < LONG_LIST then
        return finish(pcall(move, list, first, last, to, other or list))
    end
    local target = other or list
    local is_backwards = goal > from and goal <= stop and target == list
    local count = (stop - from) // LONG_LIST
    for i = 0, count do
        local start = from + LONG_LIST * (is_backwards and count - i or i)
        local piece = start + LONG_LIST - 1
        finish(pcall(move, list, start, piece < stop and piece or stop, goal + start - from, target))
        look()
    end
    return target
end

-- Like others here, first the form that is called most, and that cannot fail: `pcall` takes as long as all of it.
function world.table.insert(list, ...)
    local position, value = ...
    if select("#", ...) == 1 and type(list) == "table" and not metatable(list) then
        list[#list + 1] = position
        return
    end
    local place = tonumber(position)
    if type(list) ~= "table" or select("#", ...) ~= 2 or not place then return finish(pcall(insert, list, ...)) end
    local length = #list
    if place < 1 or place > length + 1 then
        error(where() .. "bad argument #2 to 'insert' (position out of bounds)", 0)
    end
    world.table.move(list, place, length, place + 1)
    list[place] = value
end

function world.table.remove(list, ...)
    local place = tonumber((...))
    if type(list) ~= "table" or not place then return finish(pcall(remove, list, ...)) end
    local length = #list
    if place ~= length and (place < 1 or place > length + 1) and not (length == 0 and place == 0) then
        error(where() .. "bad argument #2 to 'remove' (position out of bounds)", 0)
    end
    local value = list[place]
    world.table.move(list, place + 1, length, place)
    list[place > length and place or length] = nil
    return value
end

function world.table.unpack(list, first, last)
    if type(list) == "table" and (tonumber(last) or #list) - (tonumber(first) or 1) > LONG_LIST then
        look(LONG_CHUNK)
    end
    return finish(pcall(unpack, list, first, last))
end
world.unpack = world.table.unpack

function world.string.rep(text, count, separator)
    local each, times = #tostring(text or "") + #tostring(separator or ""), tonumber(count) or 0
    local size = each * (times + 0.0)
    if size > LONG_REPEAT then error("string.rep: a text of more than " .. LONG_REPEAT .. " bytes", 2) end
    if size > LONG_CHUNK then look(size) end
    -- Repetitions of an empty text are empty; C would count to the end.
    count = whole(count)
    return finish(pcall(rep, text, each == 0 and times > 1 and 1 or count, separator))
end

-- Functions that process a whole text within C.
local function with_a_look(change)
    return function(text, ...)
        if type(text) == "string" and #text > LONG_CHUNK then look(#text) end
        return finish(pcall(change, text, ...))
    end
end
for _, name in pairs { "lower", "reverse", "upper" } do world.string[name] = with_a_look(world.string[name]) end
for _, name in pairs { "codepoint", "len", "offset" } do world.utf8[name] = with_a_look(world.utf8[name]) end

local to_number = with_a_look(tonumber)
function world.tonumber(text, ...)
    if mathtype(text) and select("#", ...) == 0 then return text end
    return to_number(text, ...)
end

function world.string.byte(text, first, last)
    if last == nil and (first == nil or mathtype(first)) and type(text) == "string" then return byte(text, first) end
    if type(text) == "string" and #text > LONG_LIST then look(#text) end
    return finish(pcall(byte, text, first, last))
end

-- A conversion takes up to a few microseconds, and %q processes its text byte by byte.
function world.string.format(...)
    local pattern, count = (...), select("#", ...)
    if type(pattern) ~= "string" then return (finish(pcall(format, ...))) end
    if count > MANY + 1 or #pattern > LONG_CHUNK then
        error(where() .. "string.format: more than " .. MANY .. " values, or a format of more than " .. LONG_CHUNK
            .. " bytes", 0)
    end
    if find(pattern, "q", 1, true) then
        for i = 2, count do
            local value = select(i, ...)
            if type(value) == "string" and #value > LONG_CHUNK then
                error(where() .. "string.format: %q of a text of more than " .. LONG_CHUNK .. " bytes", 0)
            end
        end
    end
    local ok, text = pcall(format, ...)
    if not ok and find(text, "has no integer representation", 1, true) then
        ok, text = pcall(format, whole_values(...))
    end
    return (finish(ok, text))
end

-- A short format may request a text as long as memory is.
for _, name in pairs { "pack", "unpack", "packsize" } do
    local action = string[name]
    world.string[name] = function(...)
        local pattern = ...
        if type(pattern) == "string" then
            if #pattern > 5 * LONG_CHUNK then
                error(where() .. "string." .. name .. ": a format of more than " .. 5 * LONG_CHUNK .. " bytes", 0)
            end
            if #pattern > LONG_KEY then look(#pattern) end
            if not find(pattern, "c", 1, true) then return finish(pcall(action, ...)) end
            for size in gmatch(pattern, "c(%d+)") do
                if #size > 8 or tonumber(size) > LONG_REPEAT then
                    error(where() .. "string." .. name .. ": a text of more than " .. LONG_REPEAT .. " bytes", 0)
                end
            end
        end
        return finish(pcall(action, ...))
    end
end
