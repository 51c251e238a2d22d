-- Functions that CoppeliaSim adds to Lua's table; those that a script has defined stay.

local added = {}

function added.clone(list)
    local copy = {}
    for key, value in pairs(list) do copy[key] = value end
    return copy
end

function added.deepcopy(value, _, copies)
    if type(value) ~= "table" then return value end
    copies = copies or {}
    if not copies[value] then
        local copy = {}
        copies[value] = copy
        for key, item in next, value do copy[added.deepcopy(key, nil, copies)] = added.deepcopy(item, nil, copies) end
        setmetatable(copy, getmetatable(value))
    end
    return copies[value]
end

function added.eq(a, b)
    if type(a) ~= "table" or type(b) ~= "table" or #a ~= #b then return false end
    for key in pairs(a) do
        if b[key] == nil then return false end
    end
    for key, value in pairs(b) do
        local both_tables = type(value) == "table" and type(a[key]) == "table"
        if both_tables and not added.eq(a[key], value) or not both_tables and a[key] ~= value then return false end
    end
    return true
end

function added.keys(list)
    local found = {}
    for key in pairs(list) do found[#found + 1] = key end
    return found
end

function added.items(list, options)
    local found = {}
    for key, value in pairs(list) do found[#found + 1] = { key, value } end
    if options and options.sort then
        table.sort(found, function(a, b) return tostring(a[1]) < tostring(b[1]) end)
    end
    return found
end

function added.invert(list)
    local found = {}
    for key, value in pairs(list) do found[value] = key end
    return found
end

function added.filter(list, options)
    local start = options and options.matchKeyPrefix or ""
    local found = {}
    for key, value in pairs(list) do
        if start == "" then
            found[key] = value
        elseif string.startswith(key, start) then
            found[options.stripKeyPrefix and string.stripprefix(key, start) or key] = value
        end
    end
    return found
end

function added.isarray(list)
    if type(list) ~= "table" then return false end
    local count = 0
    for key in pairs(list) do
        if math.type(key) ~= "integer" or key < 1 then return false end
        count = count + 1
    end
    return count == #list
end

function added.find(list, item, is_equal)
    for key, value in pairs(list) do
        if is_equal and is_equal(value) or not is_equal and value == item then return key end
    end
end

function added.index(list) return function(key) return list[key] end end

function added.slice(list, first, last, step)
    local found = {}
    for i = first or 1, last or #list, step or 1 do found[#found + 1] = list[i] end
    return found
end

function added.reversed(list)
    local found = added.clone(list)
    for i = 1, #list do found[#list - i + 1] = list[i] end
    return found
end

function added.sorted(list, comes_before)
    local copy = added.clone(list)
    table.sort(copy, comes_before)
    return copy
end

-- -1, 0 or 1, by the first elements that differ.
function added.compare(a, b, compare)
    compare = compare or function(x, y) return x < y and -1 or x > y and 1 or 0 end
    for i = 1, math.min(#a, #b) do
        local order = compare(a[i], b[i])
        if order ~= 0 then return order end
    end
    return #a < #b and -1 or #a > #b and 1 or 0
end

function added.extend(list, ...)
    for _, other in ipairs { ... } do table.move(other, 1, #other, #list + 1, list) end
end

function added.add(...)
    local found = {}
    added.extend(found, ...)
    return found
end

function added.update(list, ...)
    for _, other in ipairs { ... } do
        for key, value in pairs(other) do list[key] = value end
    end
    return list
end

function added.rep(value, size)
    local found = {}
    for i = 1, size do found[i] = value end
    return found
end

function added.batched(list, size)
    local found = {}
    for i = 1, #list, size do found[#found + 1] = table.move(list, i, math.min(i + size - 1, #list), 1, {}) end
    return found
end

-- {a = {b = 1}} as {["a.b"] = 1}, and back.
function added.flatten(list, _, start, found)
    found = found or {}
    for key, value in pairs(list) do
        local name = (start or "") .. key
        if type(value) == "table" and not added.isarray(value) then
            added.flatten(value, nil, name .. ".", found)
        else
            found[name] = value
        end
    end
    return found
end

function added.unflatten(list)
    local found = {}
    for name, value in pairs(list) do
        local place, names = found, {}
        for part in string.gmatch(name, "[^.]+") do names[#names + 1] = part end
        for i = 1, #names - 1 do
            place[names[i]] = place[names[i]] or {}
            place = place[names[i]]
        end
        place[names[#names]] = value
    end
    return found
end

-- Lists within a list as parts of it, up to a depth; below 0: all of them.
function added.collapse(list, depth)
    depth = depth or 1
    if depth == 0 then return list end
    local found = {}
    for _, item in ipairs(list) do
        if added.isarray(item) then
            added.extend(found, added.collapse(item, depth - 1))
        else
            found[#found + 1] = item
        end
    end
    return found
end

added.frompairs = added.clone

function added.unpackx(list, count, first) return table.unpack(list, first or 1, count) end

function added.join(list, separator)
    local texts = {}
    for i, value in ipairs(list) do texts[i] = type(value) == "table" and added.tostring(value) or tostring(value) end
    return table.concat(texts, separator or ", ")
end

function added.tostring(list) return getAsString(list) end
function added.print(list) print(added.tostring(list)) end

function added.fromipairs(list) return added.slice(list) end

function added.val_to_str(value)
    return type(value) == "string" and string.format("%q", value) or added.tostring(value)
end

function added.key_to_str(key)
    return type(key) == "string" and string.isidentifier(key) or "[" .. added.val_to_str(key) .. "]"
end

for name, action in pairs(added) do
    if rawget(table, name) == nil then table[name] = action end
end

return added
