-- Functions that change a string in place: CoppeliaSim's Lua shares the buffers of images, so programs do not use the
-- result. Strings of Lua cannot change; the variables that hold the given string get the new one: locals of the
-- calling function, variables of functions around it, and globals.
--
-- Arguments: the script's world. Returns a function (old string, new string), called by the function of the API.

local world = ...
local getinfo, getlocal, setlocal, getupvalue, setupvalue = debug.getinfo, debug.getlocal, debug.setlocal,
    debug.getupvalue, debug.setupvalue
local format, find, type, next = string.format, string.find, type, next

local CALLER <const>, MOST <const> = 3, 255

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
