-- Variables by names with dots, such as "robot.arm.speed".

local var = {}

local function parts_of(name)
    local parts = {}
    for part in string.gmatch(name, "[^.]+") do parts[#parts + 1] = part end
    return parts
end

function var.getvar(name)
    local value = _G
    for _, part in ipairs(parts_of(name)) do
        if type(value) ~= "table" then return nil end
        value = value[part]
    end
    return value
end

function var.setvar(name, value)
    local place, parts = _G, parts_of(name)
    for i = 1, #parts - 1 do
        place[parts[i]] = place[parts[i]] or {}
        place = place[parts[i]]
    end
    place[parts[#parts]] = value
end

return var
