-- Functions that CoppeliaSim adds to Lua's math; those that a script has defined stay.

local added = {}

function added.hypot(...)
    local sum = 0
    for _, x in ipairs { ... } do sum = sum + x * x end
    return math.sqrt(sum)
end

function added.hypotn(a, b)
    local sum = 0
    for i = 1, #a do sum = sum + (a[i] - b[i]) ^ 2 end
    return math.sqrt(sum)
end

function added.sign(x) return x >= 0 and 1 or -1 end

function added.median(values)
    if #values == 0 then return nil end
    local ordered = table.sorted(values)
    local middle = (#ordered + 1) // 2
    return #ordered % 2 == 1 and ordered[middle] or (ordered[middle] + ordered[middle + 1]) / 2
end

-- As math.random: CoppeliaSim's has a generator for each script, as all generators of scripts have here.
function added.random2(low, high)
    if not low then return math.random() end
    if not high then low, high = 1, low end
    return low + math.floor(math.random() * (high - low + 1))
end

function added.randomseed2(seed) math.randomseed(seed) end

for name, action in pairs(added) do
    if rawget(math, name) == nil then math[name] = action end
end

return added
