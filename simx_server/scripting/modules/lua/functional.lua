-- Functions that take functions, as globals and as members of the module.

local functional = {}

function functional.apply(action, values) return action(table.unpack(values)) end

function functional.partial(action, ...)
    local first = table.pack(...)
    return function(...)
        local values = { table.unpack(first, 1, first.n) }
        for i = 1, select("#", ...) do values[first.n + i] = (select(i, ...)) end
        return action(table.unpack(values, 1, first.n + select("#", ...)))
    end
end

-- The results of the function for the elements of one or several lists.
function functional.map(action, ...)
    local lists, found = { ... }, {}
    for i = 1, #lists[1] do
        local values = {}
        for j, list in ipairs(lists) do values[j] = list[i] end
        found[i] = action(table.unpack(values, 1, #lists))
    end
    return found
end

function functional.foreach(action, list)
    for i = 1, #list do action(list[i]) end
end

function functional.filter(wanted, list)
    local found = {}
    for i = 1, #list do
        if wanted(list[i]) then found[#found + 1] = list[i] end
    end
    return found
end

function functional.reduce(action, list, first)
    local result, start = first, 1
    if result == nil then result, start = list[1], 2 end
    for i = start, #list do result = action(result, list[i]) end
    return result
end

function functional.any(wanted, list)
    for i = 1, #list do
        if wanted(list[i]) then return true end
    end
    return false
end

function functional.all(wanted, list) return not functional.any(function(item) return not wanted(item) end, list) end

function functional.sum(list) return functional.reduce(function(a, b) return a + b end, list, 0) end

function functional.range(first, last, step)
    if last == nil then first, last = 1, first end
    local found = {}
    for i = first, last, step or 1 do found[#found + 1] = i end
    return found
end

function functional.zip(...) return functional.map(function(...) return { ... } end, ...) end

for name, action in pairs(functional) do
    if _G[name] == nil then _G[name] = action end
end

return functional
