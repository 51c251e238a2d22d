"""Lua's standard library as scripts get it: without files, and with no single call that takes long by itself.

No hook strikes within a C function, so what takes more than linear time, or linear time on something huge, is done
in Lua there, where the hook looks at the clock and others are served. The limits are such that the C function
stays below about 0.05 s.
"""

from .lua_patterns import PATTERNS

LIBRARY = (
    rb"""
local world, where, look = ...
local error, type, load, pairs, select, tostring = error, type, load, pairs, select, tostring
local sort, concat, rep, unpack = table.sort, table.concat, string.rep, table.unpack

local LONG_SORT, LONG_CONCAT, LONG_CHUNK, LONG_REPEAT = 10000, 10000, 200000, 16000000

for _, library in pairs { "math", "string", "table", "utf8" } do
    world[library] = {}
    for key, value in pairs(_G[library]) do world[library][key] = value end
end
world.string.dump = nil
getmetatable("").__index = world.string
world.math.pow = function(x, y) return x ^ y end
world.math.ldexp = function(x, e) return x * 2.0 ^ e end
world.math.log10 = function(x) return math.log(x, 10) end
world.math.atan2 = math.atan
world.table.getn = function(t) return #t end
world.table.maxn = function(t)
    local greatest = 0
    for key in pairs(t) do
        if type(key) == "number" and key > greatest then greatest = key end
    end
    return greatest
end
world.math.randomseed(1)

world.os = { clock = os.clock, date = os.date, difftime = os.difftime, time = os.time }

local function no_files(_, name) error(where() .. "io." .. tostring(name) .. ": scripts have no files", 0) end
world.io = setmetatable({}, { __index = no_files, __metatable = false })

function world.load(chunk, name, _, environment)
    if type(chunk) == "string" and #chunk > LONG_CHUNK then
        return nil, "a chunk of more than " .. LONG_CHUNK .. " bytes cannot be loaded"
    end
    look()
    return load(chunk, name, "t", environment == nil and world or environment)
end
world.loadstring = world.load

local function before(a, b) return a < b end

function world.table.sort(list, comes_before)
    if comes_before == nil and type(list) == "table" and #list > LONG_SORT then comes_before = before end
    return sort(list, comes_before)
end

function world.table.concat(list, separator, first, last)
    first, last = first or 1, last or #list
    if last - first < LONG_CONCAT then return concat(list, separator, first, last) end
    local parts = {}
    for start = first, last, LONG_CONCAT do
        local stop = start + LONG_CONCAT - 1
        parts[#parts + 1] = concat(list, separator, start, stop < last and stop or last)
        look()
    end
    return concat(parts, separator)
end

function world.string.rep(text, count, separator)
    if type(count) == "number" and type(text) == "string" and count > 0 then
        local size = (#text + #(separator or "")) * count
        if size > LONG_REPEAT then error("string.rep: a text of more than " .. LONG_REPEAT .. " bytes", 2) end
        if size > LONG_CHUNK then look() end
    end
    return rep(text, count, separator)
end
"""
    + PATTERNS
)
"""A Lua chunk that is called with the script's world and a function that says where the script is."""
