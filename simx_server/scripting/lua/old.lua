-- What Lua 5.1 of V-REP 3 accepted and Lua 5.4 does not: a number with a fraction where a whole one is needed.
-- Lua 5.1 cuts the fraction off.

local select, pack, unpack, gmatch, find, mathtype, tointeger, huge = select, table.pack, table.unpack, string.gmatch,
    string.find, math.type, math.tointeger, math.huge

local function whole(value)
    if mathtype(value) ~= "float" or value ~= value or value == huge or value == -huge then return value end
    return tointeger(value < 0 and -(-value // 1) or value // 1) or value
end

-- The arguments of string.format, with whole numbers for %d and its like.
local function whole_values(pattern, ...)
    local values, place = pack(...), 0
    for kind in gmatch(pattern, "%%[-+ #0]*%d*%.?%d*([%a%%])") do
        if kind ~= "%" then place = place + 1 end
        if find("cdiouxX", kind, 1, true) then values[place] = whole(values[place]) end
    end
    return pattern, unpack(values, 1, select("#", ...))
end

return { whole = whole, whole_values = whole_values }
