-- Values that leave a script for the server, results that enter it, and strings that the server changes in place.
--
-- Python needs 0.3 us for an item of a table. So lists of numbers leave packed in a string, which takes a tenth.
--
-- Arguments: a function that tells the script's place, the greatest depth of tables, and a function of Python that
-- makes its own list of a packed one.

local where, max_depth, to_python = ...

local getinfo, getlocal, setlocal, getupvalue, setupvalue = debug.getinfo, debug.getlocal, debug.setlocal,
    debug.getupvalue, debug.setupvalue
local error, format, find, type, next, select, mathtype, rawequal, load = error, string.format, string.find,
    type, next, select, math.type, rawequal, load
local gmatch, tonumber, setmetatable = string.gmatch, tonumber, setmetatable
local pack, rep, packed, unpack, concat = string.pack, string.rep, table.pack, table.unpack, table.concat

-- The kind of a table that is a list of numbers and that Lua has in their order, and its length; nil for any other,
-- and for a list that would take too much of the script's memory as a string. Kinds are those of `_given` in
-- interpreter.py.
local ALONE <const>, FLOATS <const>, INTEGERS <const>, MIXED <const>, LONGEST <const> = "-", "d", "j", "m", 300000

local function kind_of(list)
    local _, first = next(list)
    local kind, count, is_mixed = mathtype(first), 0, false
    if first ~= nil and kind == nil then return nil end
    for key, item in next, list do
        count = count + 1
        local other = mathtype(item)
        if key ~= count or other ~= kind then
            if key ~= count or other == nil or count > LONGEST then return nil end
            is_mixed = true
        end
    end
    if count > LONGEST then return nil end
    return is_mixed and MIXED or kind == "integer" and INTEGERS or FLOATS, count
end

local PIECE <const> = 200                                       -- numbers that fit on Lua's stack at any time
local formats = {
    [FLOATS] = setmetatable({}, { __index = function(known, count)
        known[count] = rep(FLOATS, count)
        return known[count]
    end }),
    [INTEGERS] = setmetatable({}, { __index = function(known, count)
        known[count] = rep(INTEGERS, count)
        return known[count]
    end }),
}

local FEW <const>, few_floats = 16, {}                          -- most lists: positions and matrices
for count = 0, FEW do few_floats[count] = rep(FLOATS, count) end

-- A format of a piece of a mixed list.
local function letters(list, first, last)
    local found = {}
    for i = first, last do found[i - first + 1] = mathtype(list[i]) == "float" and FLOATS or INTEGERS end
    return concat(found)
end

-- A list as a string: its numbers, and before those of a piece of a mixed list their format.
local function as_string(list, kind, count)
    if kind == FLOATS and count <= FEW then return pack(few_floats[count], unpack(list, 1, count)) end
    if count <= PIECE and kind ~= MIXED then return pack(formats[kind][count], unpack(list, 1, count)) end
    local pieces = {}
    for first = 1, count, PIECE do
        local last = first + PIECE - 1
        if last > count then last = count end
        local form = kind == MIXED and letters(list, first, last) or formats[kind][last - first + 1]
        if kind == MIXED then pieces[#pieces + 1] = form end
        pieces[#pieces + 1] = pack(form, unpack(list, first, last))
    end
    return concat(pieces)
end

local LONG <const> = 50                                        -- numbers from which a list of Python costs less

-- A value as it can leave the script, or an error: keys of tables are text or whole numbers. Long lists of numbers in a
-- table become lists of Python, in a copy of what holds them.
local function checked(value, nesting)
    local kind = type(value)
    if kind == "thread" or kind == "userdata" then error(where() .. "a " .. kind .. " cannot leave the script", 0) end
    if kind ~= "table" then return value end
    if nesting > max_depth then error(where() .. "has a table nested too deeply, or within itself", 0) end
    local numbers, count = kind_of(value)
    if numbers then return count < LONG and value or to_python(numbers, as_string(value, numbers, count)) end
    local copy
    for key, item in next, value do
        if mathtype(key) ~= "integer" and type(key) ~= "string" then
            local what = mathtype(key) and "number with a fraction" or type(key)
            error(where() .. "a table with a " .. what .. " as a key cannot leave the script; keys are text or whole "
                .. "numbers", 0)
        end
        if mathtype(item) == nil then
            local light = checked(item, nesting + 1)
            if not rawequal(light, item) then
                if not copy then
                    copy = {}
                    for name, other in next, value do copy[name] = other end
                end
                copy[key] = light
            end
        end
    end
    return copy or value
end

-- The results of a function of the script.
local function plain_all(...)
    for i = 1, select("#", ...) do
        if mathtype((select(i, ...))) == nil then
            local values = packed(...)
            for place = i, values.n do values[place] = checked(values[place], 1) end
            return unpack(values, 1, values.n)
        end
    end
    return ...
end

-- An argument as it leaves, after its kind.
local function with_kind(value)
    if type(value) == "table" then
        local kind, count = kind_of(value)
        if kind then return kind, as_string(value, kind, count) end
    end
    return ALONE, checked(value, 1)
end

-- Before the values the kinds of all, one letter for each.
local function with_lists(...)
    local count, first, second, third = select("#", ...), ...
    if count <= 3 then                                          -- of most calls, without a table of the values
        local kinds, kind
        kinds, first = with_kind(first)
        if count == 1 then return kinds, first end
        kind, second = with_kind(second)
        kinds = kinds .. kind
        if count == 2 then return kinds, first, second end
        kind, third = with_kind(third)
        return kinds .. kind, first, second, third
    end
    local values, kinds = packed(...), {}
    for i = 1, count do kinds[i], values[i] = with_kind(values[i]) end
    return concat(kinds), unpack(values, 1, count)
end

local simple = { ["nil"] = true, boolean = true, number = true, string = true }

-- The arguments of a function of the API, and before them their kinds; nil where all are simple values.
local function leaving(...)
    for i = 1, select("#", ...) do
        if not simple[type((select(i, ...)))] then return with_lists(...) end
    end
    return nil, ...
end

-- Functions that make results from flat ones, by shape; see `crossing/flat.py`. A table gets places up to a power of
-- two, as one that was filled item by item.
local function builder(shape)
    local names, results, count = {}, {}, 0
    for part in gmatch(shape, "[^,]+") do
        local length, items = tonumber(part) or 1, {}
        for i = 1, length do
            count = count + 1
            items[i], names[count] = "v" .. count, "v" .. count
        end
        if part ~= ALONE then
            local places = 1
            while places < length do places = places * 2 end
            for i = length + 1, length > 0 and places or 0 do items[i] = "nil" end
            items = { "{" .. concat(items, ",") .. "}" }
        end
        results[#results + 1] = items[1]
    end
    local made = "return function(" .. concat(names, ",") .. ") return " .. concat(results, ",") .. " end"
    return load(made, "=sandbox", "t", {})()
end

local builders = setmetatable({ [true] = false, [false] = false, switch = false, wait = false }, {
    __index = function(known, shape)
        local build = builder(shape)
        known[shape] = build
        return build
    end,
})

-- CoppeliaSim's Lua shares the buffers of images, so programs do not use the result of a function that changes one.
-- Strings of Lua cannot change; the variables that hold the given string get the new one: locals of the calling
-- function, variables of functions around it, and globals.
--
-- Arguments: the script's world. Returns a function (old string, new string), called by the function of the API.
local CALLER <const>, MOST <const> = 3, 255

local function replacing(world)
    return function(old, new)
        if type(old) ~= "string" or type(new) ~= "string" then return end
        local place = format("%p", old)
        local function is_old(value) return type(value) == "string" and format("%p", value) == place end
        for i = 1, MOST do
            local name, value = getlocal(CALLER, i)
            if not name then break end
            if not find(name, "^%(") and is_old(value) then setlocal(CALLER, i, new) end
        end
        local info = getinfo(CALLER, "f")
        for i = 1, MOST do
            local name, value = getupvalue(info.func, i)
            if not name then break end
            if is_old(value) then setupvalue(info.func, i, new) end
        end
        local globals = {}
        for name, value in next, world do
            if is_old(value) then globals[#globals + 1] = name end
        end
        for i = 1, #globals do world[globals[i]] = new end
    end
end

return { plain_all = plain_all, leaving = leaving, builders = builders, replacing = replacing }
