-- CBOR (RFC 8949): values as bytes, and back.
--
-- A table with the keys 1, 2 ... is an array, any other one a map. Tags are read over; a map's order is not kept.

local cbor = { null = nil, undefined = nil }

local DEEPEST, MOST = 100, 1000000
local pack, unpack, byte, char, sub = string.pack, string.unpack, string.byte, string.char, string.sub

local function head(major, number)
    local first = major << 5
    if number < 24 then return char(first | number) end
    if number < 0x100 then return pack(">BB", first | 24, number) end
    if number < 0x10000 then return pack(">BI2", first | 25, number) end
    if number < 0x100000000 then return pack(">BI4", first | 26, number) end
    return pack(">BI8", first | 27, number)
end

local function is_array(value)
    local count = 0
    for key in pairs(value) do
        if math.type(key) ~= "integer" or key < 1 then return false end
        count = count + 1
    end
    return count == #value
end

local encode

local function encode_table(value, depth)
    local parts = {}
    if is_array(value) then
        parts[1] = head(4, #value)
        for i = 1, #value do parts[#parts + 1] = encode(value[i], depth) end
        return table.concat(parts)
    end
    local count = 0
    for key, item in pairs(value) do
        parts[#parts + 1] = encode(key, depth) .. encode(item, depth)
        count = count + 1
    end
    return head(5, count) .. table.concat(parts)
end

function encode(value, depth)
    if depth > DEEPEST then error("cbor.encode: a table that is nested too deeply", 0) end
    local kind = type(value)
    if kind == "nil" then return "\xf6" end
    if kind == "boolean" then return value and "\xf5" or "\xf4" end
    if kind == "string" then return head(utf8.len(value) and 3 or 2, #value) .. value end
    if kind == "table" then return encode_table(value, depth + 1) end
    if math.type(value) == "integer" then
        if value >= 0 then return head(0, value) end
        return head(1, -1 - value)
    end
    if kind == "number" then return pack(">Bd", 0xfb, value) end
    error("cbor.encode: a " .. kind .. " has no form in CBOR", 0)
end

local function half(bits)
    local sign, exponent, fraction = bits >> 15 == 1 and -1 or 1, bits >> 10 & 31, bits & 1023
    if exponent == 0 then return sign * fraction * 2.0 ^ -24 end
    if exponent < 31 then return sign * (fraction + 1024) * 2.0 ^ (exponent - 25) end
    return fraction == 0 and sign * math.huge or 0.0 / 0.0
end

local BREAK = {}
local WIDTHS = { [24] = ">I1", [25] = ">I2", [26] = ">I4", [27] = ">I8" }

local decode

local function items(data, place, count, depth)
    local found, number = {}, 0
    while not count or number < count do
        local item
        item, place = decode(data, place, depth)
        if item == BREAK then break end
        number = number + 1
        if number > MOST then error("cbor.decode: too many items", 0) end
        found[number] = item
    end
    return found, place, number
end

local function map(data, place, count, depth)
    local listed, number
    listed, place, number = items(data, place, count and 2 * count, depth)
    local found = {}
    for i = 1, number, 2 do
        if listed[i] ~= nil and listed[i] == listed[i] then found[listed[i]] = listed[i + 1] end
    end
    return found, place
end

local function simple(data, place, low, number)
    if low == 20 or low == 21 then return low == 21, place, low == 21 and "true" or "false" end
    if low == 22 then return nil, place, "null" end
    if low == 25 then return half(number), place, "half" end
    if low == 26 then return unpack(">f", data, place - 4), place, "single" end
    if low == 27 then return unpack(">d", data, place - 8), place, "double" end
    if low == 31 then return BREAK, place, "__break" end
    return nil, place, "undefined"
end

function decode(data, place, depth)
    if depth > DEEPEST then error("cbor.decode: a value that is nested too deeply", 0) end
    local first = byte(data, place)
    if not first then error("cbor.decode: the data end too early", 0) end
    local major, low, number = first >> 5, first & 31, first & 31
    place = place + 1
    if WIDTHS[low] then
        local size = 1 << (low - 24)
        if place + size - 1 > #data then error("cbor.decode: the data end too early", 0) end
        number, place = unpack(WIDTHS[low], data, place)
    elseif low == 31 then
        number = nil
    elseif low > 27 then
        error("cbor.decode: " .. first .. " begins no value", 0)
    end
    if major == 0 then return number, place, "UINT" end
    if major == 1 then return -1 - number, place, "NINT" end
    if major == 2 or major == 3 then
        local kind = major == 2 and "BIN" or "TEXT"
        if not number then
            local parts
            parts, place = items(data, place, nil, depth + 1)
            return table.concat(parts), place, kind
        end
        if number < 0 or number > #data - place + 1 then error("cbor.decode: the data end too early", 0) end
        return sub(data, place, place + number - 1), place + number, kind
    end
    if major == 4 then
        local found
        found, place = items(data, place, number, depth + 1)
        return found, place, "ARRAY"
    end
    if major == 5 then
        local found
        found, place = map(data, place, number, depth + 1)
        return found, place, "MAP"
    end
    if major == 6 then return decode(data, place, depth + 1) end
    return simple(data, place, low, number)
end

function cbor.encode(value) return encode(value, 0) end

-- The value, the place behind it, and its type in CBOR.
function cbor.decode(data, place)
    local value, behind, kind = decode(data, place or 1, 0)
    if value == BREAK then error("cbor.decode: a break outside of a list", 2) end
    return value, behind, kind
end

return cbor
