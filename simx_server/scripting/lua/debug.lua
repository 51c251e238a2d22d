-- Errors, their handlers and `debug` for scripts.
--
-- Lua's own would show the functions of the sandbox, and `debug` would give access to it. A script sees only
-- its own functions; those of the server and of Lua's library look like C functions, as in CoppeliaSim.
-- Arguments: the script's world, a copy of it that no script can change, two functions of the hook, and one
-- that returns whether a function is the entry point of calls from the server.

local world, own, where, look, is_entrance = ...
local getinfo, running, error, pcall, xpcall, type, select, tonumber, next, pairs, rawget, setmetatable =
    debug.getinfo, coroutine.running, error, pcall, xpcall, type, select, tonumber, next, pairs, rawget, setmetatable
local getupvalue = debug.getupvalue
local format, concat, find, gsub, tointeger = string.format, table.concat, string.find, string.gsub, math.tointeger

-- A long stack shows its innermost and outermost functions; an even longer one only the innermost ones.
local FIRST, LAST, DEEPEST = 10, 11, 200

-- The full name of a function of the API: the upvalue of what the sandbox's `bind` returns.
local function bound_name(action)
    if getinfo(action, "S").source ~= "=sandbox" then return nil end
    for i = 1, 255 do
        local key, value = getupvalue(action, i)
        if not key then return nil end
        if key == "bound_name" then return value end
    end
end

-- Names of the functions of Lua's library that a script gets, found on first use.
local names
local function name_of(action)
    if not names then
        names = {}
        for name, value in next, own do
            if type(value) == "function" then names[value] = name end
        end
        for space, members in next, own do
            if type(members) == "table" and members ~= own then
                for name, value in next, members do
                    if type(value) == "function" and type(name) == "string" then
                        names[value] = names[value] or space .. "." .. name
                    end
                end
            end
        end
    end
    return names[action] or bound_name(action)
end

local function is_own(frame) return frame.what ~= "C" and frame.source ~= "=sandbox" end

-- The visible frames, the innermost first. `aside`: while a handler runs, those of the error.
local aside
local handle_error

local function frames_of(thread, from, most)
    local found, level = {}, from - 1
    while #found < most do
        local frame
        level = level + 1
        if thread then frame = getinfo(thread, level, "Slnutf") else frame = getinfo(level + 1, "Slnutf") end
        if not frame or is_entrance(frame.func) then break end
        if not thread and frame.func == handle_error and aside then
            for i = 1, #aside do found[#found + 1] = aside[i] end
            break
        end
        if is_own(frame) then
            found[#found + 1] = frame
        else
            frame.given = name_of(frame.func)
            if frame.given then found[#found + 1] = frame end
        end
    end
    return found
end

local mains = setmetatable({}, { __mode = "k" })

-- The name by which a script's function is a global; also when it was called by another name.
local function global_name(frame)
    if frame.name and rawget(world, frame.name) == frame.func then return frame.name end
    for name, value in next, world do
        if value == frame.func and type(name) == "string" then return name end
    end
    return nil
end

local function line_of(frame)
    if frame.given then return "\n\t[C]: in function '" .. frame.given .. "'" end
    local line = frame.currentline > 0 and frame.currentline .. ":" or ""
    local place = "\n\t" .. frame.short_src .. ":" .. line .. " in "
    local name = global_name(frame)
    local what = mains[frame.func] and "main chunk"
        or name and format("function '%s'", name)
        or frame.namewhat ~= "" and format("%s '%s'", frame.namewhat, frame.name)
        or format("function <%s:%d>", frame.short_src, frame.linedefined)
    return place .. what .. (frame.istailcall and "\n\t(...tail calls...)" or "")
end

local function traceback(message, frames, from)
    local lines, count = { message and message .. "\n" or "", "stack traceback:" }, #frames
    local last = count < DEEPEST and LAST or 0
    local skipped = count - from - FIRST - last                     -- one less than are left out, as in Lua
    for i = from, count do
        if skipped > 0 and i == from + FIRST then
            lines[#lines + 1] = last > 0 and format("\n\t...\t(skipping %d levels)", skipped) or "\n\t..."
        end
        if skipped <= 0 or i < from + FIRST or i > count - last then lines[#lines + 1] = line_of(frames[i]) end
    end
    return concat(lines)
end

local function complain(number, name, problem)
    error(where() .. format("bad argument #%d to '%s' (%s)", number, name, problem), 0)
end

local function whole(value, number, name)
    local given = tointeger(value) or type(value) == "string" and tointeger(tonumber(value))
    if not given then complain(number, name, "number expected, got " .. type(value)) end
    return given
end

-- A level as a C function would count it: it has a caller even when it is called last (``return f()``).
local function called_last(level)
    return level > 1 and getinfo(2, "t").istailcall and level - 1 or level
end

world.debug = {}

function world.debug.traceback(...)
    local thread, message, level = nil, ...
    if type(message) == "thread" then thread, message, level = ... end
    if message ~= nil and type(message) ~= "string" and type(message) ~= "number" then return message end
    if thread == running() then thread = nil end
    if level == nil then level = thread and 0 or 1 else level = whole(level, thread and 3 or 2, "traceback") end
    if not thread then level = called_last(level) end
    local frames = level < 0 and {} or frames_of(thread, thread and 0 or 1, DEEPEST)
    return (traceback(message, frames, level + 1))
end

local KEYS = {
    S = { "source", "short_src", "what", "linedefined", "lastlinedefined" },
    l = { "currentline" }, n = { "name", "namewhat" }, t = { "istailcall" }, u = { "nups", "nparams", "isvararg" },
    f = { "func" }, L = { "activelines" },
}

-- The visible properties of a function: the server's and Lua's own functions show those of a C function.
function world.debug.getinfo(...)
    local thread, subject, options = nil, ...
    if type(subject) == "thread" then thread, subject, options = ... end
    local number = thread and 2 or 1
    if options == nil then options = "SlntufL" end
    if type(options) ~= "string" or find(options, "[^SlntufLr]") then
        complain(number + 1, "getinfo", "invalid option")
    end
    local frame
    if type(subject) == "function" then
        frame = getinfo(subject, "SlutfL")
        frame.namewhat = ""
    else
        local level = whole(subject, number, "getinfo")
        if level < 0 then complain(number, "getinfo", "level out of range") end
        if thread == running() then thread = nil end
        if not thread then level = called_last(level) end
        frame = frames_of(thread, thread and 0 or 1, level + 1)[level + 1]
        if not frame then return nil end
    end
    local is_foreign = not is_own(frame)
    if is_foreign then
        frame = {
            source = "=[C]", short_src = "[C]", what = "C", linedefined = -1, lastlinedefined = -1, currentline = -1,
            name = frame.name and (frame.given or frame.name), namewhat = frame.namewhat,
            istailcall = frame.istailcall, nups = 0, nparams = 0, isvararg = true, func = frame.func,
        }
    elseif mains[frame.func] then
        frame.what, frame.linedefined, frame.lastlinedefined = "main", 0, 0
    end
    if find(options, "L", 1, true) and not is_foreign then frame.activelines = getinfo(frame.func, "L").activelines end
    local known = {}
    for letter, keys in pairs(KEYS) do
        if find(options, letter, 1, true) then
            for i = 1, #keys do known[keys[i]] = frame[keys[i]] end
        end
    end
    return known
end

-- A memory error comes after few instructions and much time, so each error is followed by a check of the
-- clock.
local function handled(ok, ...)
    if ok then return true, ... end
    look()
    local problem = ...
    if type(problem) == "string" then problem = gsub(problem, "^sandbox:%d+: ", where) end  -- of error("...", 2)
    return false, problem
end

function world.pcall(...)
    if select("#", ...) == 0 then complain(1, "pcall", "value expected") end
    return handled(pcall(...))
end

-- Lua calls a handler at the place of the error, also in the hook that stops a script, where the handler could
-- not be stopped. So only the frames are kept there, and the handler is called after the unwinding.
local raised
local function note(problem)
    -- After a stack overflow little of the stack is left for a walk through it.
    local is_full = type(problem) == "string" and find(problem, "stack overflow", 1, true)
    raised = is_full and {} or frames_of(nil, 1, DEEPEST)
    return problem
end

function handle_error(handle, problem)
    local _, answer = pcall(handle, problem)
    return answer
end

local function with_handler(handle, ok, ...)
    if ok then return true, ... end
    look()
    local before = aside
    aside, raised = raised, nil
    local answer = handle_error(handle, (...))
    aside = before
    return false, answer
end

function world.xpcall(action, handle, ...)
    if type(handle) ~= "function" then complain(2, "xpcall", "function expected, got " .. type(handle)) end
    return with_handler(handle, xpcall(action, note, ...))
end

return { complain = complain, is_main = function(chunk) mains[chunk] = true end }
