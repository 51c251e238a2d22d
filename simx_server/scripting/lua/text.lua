-- Printed text of a script: values in CoppeliaSim's form, tables with their contents.
--
-- The text contains no addresses, so two runs print the same lines. A script's `__tostring` is called, as by
-- Lua's print.
-- Arguments: the script's world, the function that receives a line, the greatest depth, the hook's check of
-- the clock, a function that completes a namespace of the API.

local world, output, max_depth, look, complete = ...
local type, tostring, next, rawget, rawequal, select = type, tostring, next, rawget, rawequal, select
local concat, sort, pack, unpack, find, match, length, mathtype, mathhuge, metatable = table.concat, table.sort,
    table.pack, table.unpack, string.find, string.match, utf8.len, math.type, math.huge, debug.getmetatable

local LONG_STRING, LONGEST, HUGE = 160, 10000, 1000000

local show

local function quoted(text)
    look(#text)
    if #text > HUGE then return "[buffer string]" end
    if find(text, "[^%C\t\n\r]") or not length(text) then return "[buffer string]" end
    if #text > LONG_STRING then return "[long string]" end
    return '"' .. text .. '"'
end

local ORDER = { boolean = 1, number = 2, string = 3 }

-- The keys of a table, sorted, and their number; no keys if these are 1, 2 ... without a gap.
local function keys_of(value, most)
    local keys, count, greatest = {}, 0, 0
    for key in next, value do
        count = count + 1
        if count <= most then keys[count] = key end
        if mathtype(key) ~= "integer" or key < 1 then greatest = mathhuge
        elseif key > greatest then greatest = key end
    end
    if greatest == count then return nil, count end
    sort(keys, function(a, b)
        local first, second = ORDER[type(a)] or 4, ORDER[type(b)] or 4
        if first ~= second then return first < second end
        if first == 2 or first == 3 then return a < b end
        return first == 1 and not a and b
    end)
    return keys, count
end

local function show_table(value, above, room)
    local depth = #above + 1
    local nested = depth > max_depth
    for i = 1, #above do nested = nested or rawequal(above[i], value) end
    if nested then return "{...}" end
    above[depth] = value
    complete(value)
    local keys, count = keys_of(value, room)
    local parts = {}
    for i = 1, count do
        if room <= 0 then
            parts[i] = "..."
            break
        end
        local key = i
        if keys then key = keys[i] end
        local text = show(rawget(value, key), above, room)
        if #text > 2 * LONGEST then text = "[long string]" end
        if keys then
            local name = show(key, above, room)
            text = (#name > 2 * LONGEST and "[long string]" or match(name, '^"?(.-)"?$')) .. "=" .. text
        end
        parts[i] = text
        room = room - #text - 2
    end
    above[depth] = nil
    return "{" .. concat(parts, ", ") .. "}"
end

function show(value, above, room)
    local kind = type(value)
    if kind == "string" then return quoted(value) end
    if kind == "nil" or kind == "boolean" or kind == "number" then return tostring(value) end
    local meta = metatable(value)
    if type(meta) == "table" and rawget(meta, "__tostring") ~= nil then return tostring(value) end
    if kind == "table" then return show_table(value, above, room) end
    return "[" .. kind .. "]"
end

local function line(bare, ...)
    local texts = pack(...)
    for i = 1, texts.n do
        local value = texts[i]
        texts[i] = bare and type(value) == "string" and value or show(value, {}, LONGEST)
    end
    return concat(texts, ", ")
end

function world.print(...) output(line(true, ...)) end
world.printToConsole = world.print

function world.getAsString(...) return line(select("#", ...) == 1, ...) end

function world.printf(pattern, ...)
    local values = pack(...)
    for i = 1, values.n do
        local kind = type(values[i])
        if kind ~= "string" and kind ~= "number" then values[i] = line(true, values[i]) end
    end
    output(world.string.format(pattern, unpack(values, 1, values.n)))
end

return function(value) return line(true, value) end
