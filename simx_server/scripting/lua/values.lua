-- Values that leave a script for the server, and strings that the server changes in place.
--
-- Python needs 0.3 us for an item of a table. So lists of numbers leave packed in a string, which takes a tenth.
--
-- Arguments: a function that tells the script's place, the greatest depth of tables, and a function of Python that
-- makes its own list of a packed one.

local where, max_depth, to_python = ...

local getinfo, getlocal, setlocal, getupvalue, setupvalue = debug.getinfo, debug.getlocal, debug.setlocal,
    debug.getupvalue, debug.setupvalue
local error, format, find, type, next, select, mathtype, rawequal = error, string.format, string.find, type, next,
    select, math.type, rawequal
local pack, rep, packed, unpack, concat = string.pack, string.rep, table.pack, table.unpack, table.concat

-- The kind of a table that is a list of numbers and that Lua has in their order, and its length; nil for any other,
-- and for a list that would take too much of the script's memory as a string. Kinds are those of `_given` in
-- interpreter.py.
local ALONE <const>, FLOATS <const>, INTEGERS <const>, MIXED <const>, LONGEST <const> = "-", "d", "j", "m", 300000

local function kind_of(list)
    local count, floats = 0, 0
    for key, item in next, list do
        local kind = mathtype(item)
        count = count + 1
        if key ~= count or kind == nil or count > LONGEST then return nil end
        if kind == "float" then floats = floats + 1 end
    end
    return floats == count and FLOATS or floats == 0 and INTEGERS or MIXED, count
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

-- A format of a piece of a mixed list.
local function letters(list, first, last)
    local found = {}
    for i = first, last do found[i - first + 1] = mathtype(list[i]) == "float" and FLOATS or INTEGERS end
    return concat(found)
end

-- A list as a string: its numbers, and before those of a piece of a mixed list their format.
local function as_string(list, kind, count)
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

-- Before the values the kinds of all, one letter for each.
local function with_lists(...)
    local values, kinds = packed(...), {}
    for i = 1, values.n do
        local value, kind, count = values[i], nil, nil
        if type(value) == "table" then kind, count = kind_of(value) end
        if kind then
            values[i] = as_string(value, kind, count)
        else
            values[i] = checked(value, 1)
        end
        kinds[i] = kind or ALONE
    end
    return concat(kinds), unpack(values, 1, values.n)
end

-- The arguments of a function of the API, and before them their kinds; nil where no argument is a table.
local function leaving(...)
    for i = 1, select("#", ...) do
        local value = select(i, ...)
        if type(value) == "table" then return with_lists(...) end
        if mathtype(value) == nil then checked(value, 1) end
    end
    return nil, ...
end

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

return { plain_all = plain_all, leaving = leaving, replacing = replacing }
