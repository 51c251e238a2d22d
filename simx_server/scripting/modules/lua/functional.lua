-- Functions that take functions. The sandbox makes them globals where a script has no such variable.

local functional = {}

-- Call a function with values, of which the last one may be a list of further ones.
function functional.apply(action, ...)
    local values = table.pack(...)
    local last = values[values.n]
    if type(last) == "table" then
        values.n = values.n - 1 + #last
        table.move(last, 1, #last, values.n - #last + 1, values)
        if #last == 0 then values[values.n + 1] = nil end
    end
    return action(table.unpack(values, 1, values.n))
end

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

function functional.foreach(action, ...) functional.map(action, ...) end

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

function functional.prod(list) return functional.reduce(function(a, b) return a * b end, list, 1) end
function functional.identity(...) return ... end
function functional.negate(action) return function(...) return not action(...) end end

-- Iterate over a list of lists, with the elements of each.
function functional.iter(list)
    local i = 0
    return function()
        i = i + 1
        if i <= #list then return table.unpack(list[i]) end
    end
end

functional.operator = {
    add = function(a, b) return a + b end, sub = function(a, b) return a - b end,
    mul = function(a, b) return a * b end, div = function(a, b) return a / b end,
    mod = function(a, b) return a % b end, idiv = function(a, b) return a // b end,
    pow = function(a, b) return a ^ b end,
    land = function(a, b) return a & b end, lor = function(a, b) return a | b end,
    lxor = function(a, b) return a ~ b end, lshl = function(a, b) return a << b end,
    lshr = function(a, b) return a >> b end,
    eq = function(a, b) return a == b end, neq = function(a, b) return a ~= b end,
    lt = function(a, b) return a < b end, le = function(a, b) return a <= b end,
    gt = function(a, b) return a > b end, ge = function(a, b) return a >= b end,
}

function functional.zip(...) return functional.map(function(...) return { ... } end, ...) end

return functional
