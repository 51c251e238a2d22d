-- Lua's patterns, matched in Lua where the C library might take long.
--
-- Lua's own matcher tries every way to share the subject out among the pattern's repetitions, within one C
-- call that cannot be interrupted: seconds for forty letters, years for eighty. Its work is at most the
-- subject's length to the power of one more than the number of repetitions. Where that bound is small the C
-- function is called. Where it is large, the matcher below does the same search: it is about twenty times
-- slower, but the hook checks the clock meanwhile, so the script can be stopped and the server answers other
-- clients. Results are the same; a script sees no difference. This file replaces the functions of the script's
-- `string` that take patterns.

local world, look = ...
local byte, char, sub, find, match, gmatch, gsub =
    string.byte, string.char, string.sub, string.find, string.match, string.gmatch, string.gsub
local error, tostring, type, unpack = error, tostring, type, table.unpack
local mathtype, SPECIAL = math.type, "[%^%$%*%+%?%.%(%)%[%]%%%-]"
local BUDGET, LONGEST, WINDOW = 1000000, 100000, 1000000

-- Whether the C library is certain to be quick. A repetition at the very end never goes back.
local function is_quick(subject, pattern)
    local length, cost, at, last = #subject, #subject, 1, #pattern
    if length > WINDOW then look(length) end
    if length * (last + 1) > 16 * BUDGET or last > 10000 then return false end
    while at < last do
        local letter = byte(pattern, at)
        if letter == 37 then                                                -- %
            local kind = byte(pattern, at + 1)
            if kind == 98 or kind >= 48 and kind <= 57 then cost = cost * length end
            at = at + 1
        elseif letter == 42 or letter == 43 or letter == 45 then            -- * + -
            cost = cost * length
        end
        if cost > BUDGET then return false end
        at = at + 1
    end
    -- A byte may be compared with each one of a class.
    local open = last > 50 and find(pattern, "[", 1, true)
    return cost <= BUDGET and (not open or cost * (last - open) <= 16 * BUDGET)
end

-- Each match processes the whole replacement.
local function is_replaced_quickly(subject, replacement)
    return type(replacement) ~= "string" or #subject * #replacement < 16 * BUDGET
        or not find(replacement, "%", 1, true)
end

-- The bytes of a class such as "%a", "[^x]" or ".".
local function members(class)
    local set = {}
    for code = 0, 255 do set[code] = find(char(code), "^" .. class) ~= nil end
    return set
end

local function class_end(pattern, at)
    local letter = byte(pattern, at)
    if letter == 37 then
        if at >= #pattern then error("malformed pattern (ends with '%')", 0) end
        return at + 2
    end
    if letter ~= 91 then return at + 1 end                                  -- [
    at = at + 1
    if byte(pattern, at) == 94 then at = at + 1 end                         -- ^
    repeat
        local inner = byte(pattern, at)
        if not inner then error("malformed pattern (missing ']')", 0) end
        at = at + (inner == 37 and 2 or 1)
    until byte(pattern, at) == 93
    return at + 1
end

-- A pattern as a list of steps, after its anchor.
local function compile(pattern, at)
    local steps, known, last = {}, {}, #pattern
    local function class(from, to)
        local text = sub(pattern, from, to)
        known[text] = known[text] or members(text == "^" and "%^" or text)
        return known[text]
    end
    while at <= last do
        local letter, following = byte(pattern, at, at + 1)
        if letter == 40 and following == 41 then steps[#steps + 1] = { kind = "position" } at = at + 2
        elseif letter == 40 then steps[#steps + 1] = { kind = "open" } at = at + 1
        elseif letter == 41 then steps[#steps + 1] = { kind = "close" } at = at + 1
        elseif letter == 36 and at == last then steps[#steps + 1] = { kind = "end" } at = at + 1
        elseif letter == 37 and following == 98 then
            if at + 3 > last then error("malformed pattern (missing arguments to '%b')", 0) end
            local first, second = byte(pattern, at + 2, at + 3)
            steps[#steps + 1] = { kind = "balance", first = first, second = second }
            at = at + 4
        elseif letter == 37 and following == 102 then
            if byte(pattern, at + 2) ~= 91 then error("missing '[' after '%f' in pattern", 0) end
            local stop = class_end(pattern, at + 2)
            steps[#steps + 1] = { kind = "frontier", set = class(at + 2, stop - 1) }
            at = stop
        elseif letter == 37 and following and following >= 48 and following <= 57 then
            steps[#steps + 1] = { kind = "again", index = following - 48 }
            at = at + 2
        else
            local stop = class_end(pattern, at)
            local step = { kind = "one", set = class(at, stop - 1) }
            local mark = byte(pattern, stop)
            if mark == 42 then step.kind = "most" step.least = 0 stop = stop + 1
            elseif mark == 43 then step.kind = "most" step.least = 1 stop = stop + 1
            elseif mark == 45 then step.kind = "fewest" stop = stop + 1
            elseif mark == 63 then step.kind = "maybe" stop = stop + 1 end
            steps[#steps + 1] = step
            at = stop
        end
    end
    return steps
end

-- The end of a match that starts at `at`, and its captures as a list of {from, to}; nil if there is none.
local function try(steps, subject, begin)
    local length, starts, stops, open = #subject, {}, {}, 0
    local function go(index, at)
        while true do
            local step = steps[index]
            if not step then return at end
            local kind = step.kind
            if kind == "one" then
                local code = byte(subject, at)
                if not code or not step.set[code] then return nil end
                at = at + 1
            elseif kind == "most" then
                local set, stop = step.set, at
                while true do
                    local code = byte(subject, stop)
                    if not code or not set[code] then break end
                    stop = stop + 1
                end
                for from = stop, at + step.least, -1 do
                    local found = go(index + 1, from)
                    if found then return found end
                end
                return nil
            elseif kind == "fewest" then
                while true do
                    local found = go(index + 1, at)
                    if found then return found end
                    local code = byte(subject, at)
                    if not code or not step.set[code] then return nil end
                    at = at + 1
                end
            elseif kind == "maybe" then
                local code = byte(subject, at)
                if code and step.set[code] then
                    local found = go(index + 1, at + 1)
                    if found then return found end
                end
            elseif kind == "open" or kind == "position" then
                open = open + 1
                starts[open], stops[open] = at, kind == "position" and "position" or false
                local found = go(index + 1, at)
                if not found then open = open - 1 end
                return found
            elseif kind == "close" then
                local capture = open
                while capture > 0 and stops[capture] do capture = capture - 1 end
                if capture == 0 then error("invalid pattern capture", 0) end
                stops[capture] = at
                local found = go(index + 1, at)
                if not found then stops[capture] = false end
                return found
            elseif kind == "end" then
                if at ~= length + 1 then return nil end
            elseif kind == "balance" then
                if byte(subject, at) ~= step.first then return nil end
                local depth, stop = 1, at + 1
                while depth > 0 do
                    local code = byte(subject, stop)
                    if not code then return nil end
                    if code == step.second then depth = depth - 1
                    elseif code == step.first then depth = depth + 1 end
                    stop = stop + 1
                end
                at = stop
            elseif kind == "frontier" then
                local before, after = at > 1 and byte(subject, at - 1) or 0, byte(subject, at) or 0
                if step.set[before] or not step.set[after] then return nil end
            else
                local from, to = starts[step.index], stops[step.index]
                if step.index > open or not to then error("invalid capture index %" .. step.index, 0) end
                if to == "position" then return nil end
                local text = sub(subject, from, to - 1)
                if sub(subject, at, at + #text - 1) ~= text then return nil end
                at = at + #text
            end
            index = index + 1
        end
    end
    local stop = go(1, begin)
    if not stop then return nil end
    local captures = {}
    for capture = 1, open do
        local to = stops[capture]
        if not to then error("unfinished capture", 0) end
        captures[capture] = to == "position" and starts[capture] or sub(subject, starts[capture], to - 1)
    end
    return stop, captures
end

local function first_from(init, length)
    init = init or 1
    if init < 0 then init = length + init + 1 end
    return init < 1 and 1 or init
end

local function search(subject, pattern, init)
    local anchored = byte(pattern, 1) == 94
    local steps = compile(pattern, anchored and 2 or 1)
    for begin = first_from(init, #subject), #subject + 1 do
        local stop, captures = try(steps, subject, begin)
        if stop then return begin, stop, captures end
        if anchored then return nil end
    end
    return nil
end

local function texts(subject, pattern, name)
    if type(subject) == "number" then subject = tostring(subject) end
    if type(pattern) == "number" then pattern = tostring(pattern) end
    if type(subject) ~= "string" or type(pattern) ~= "string" then
        error("string." .. name .. ": a text and a pattern are needed", 3)
    end
    if #pattern > LONGEST and name ~= "find" then
        error("string." .. name .. ": a pattern of more than " .. LONGEST .. " bytes", 3)
    end
    return subject, pattern
end

local function is_plain(pattern)
    if #pattern <= LONGEST then return not find(pattern, SPECIAL) end
    for start = 1, #pattern, LONGEST do
        look(LONGEST)
        if find(sub(pattern, start, start + LONGEST - 1), SPECIAL) then return false end
    end
    return true
end

function world.string.find(subject, pattern, init, plain)
    subject, pattern = texts(subject, pattern, "find")
    if plain or is_plain(pattern) then
        if #subject * #pattern > 64 * BUDGET and #pattern > 64 then
            error("string.find: a text of " .. #pattern .. " bytes is too long to be looked for", 2)
        end
        if #subject <= WINDOW or init ~= nil and mathtype(init) ~= "integer" then
            return find(subject, pattern, init, true)
        end
        for start = first_from(init, #subject), #subject + 1, WINDOW do
            look(WINDOW)
            local at = find(sub(subject, start, start + WINDOW + #pattern - 2), pattern, 1, true)
            if at then return start + at - 1, start + at + #pattern - 2 end
        end
        return nil
    end
    if #pattern > LONGEST then error("string.find: a pattern of more than " .. LONGEST .. " bytes", 2) end
    if is_quick(subject, pattern) then return find(subject, pattern, init) end
    local begin, stop, captures = search(subject, pattern, init)
    if not begin then return nil end
    return begin, stop - 1, unpack(captures)
end

local function results(subject, begin, stop, captures)
    if #captures == 0 then return sub(subject, begin, stop - 1) end
    return unpack(captures)
end

function world.string.match(subject, pattern, init)
    subject, pattern = texts(subject, pattern, "match")
    if is_quick(subject, pattern) then return match(subject, pattern, init) end
    local begin, stop, captures = search(subject, pattern, init)
    if not begin then return nil end
    return results(subject, begin, stop, captures)
end

function world.string.gmatch(subject, pattern, init)
    subject, pattern = texts(subject, pattern, "gmatch")
    if is_quick(subject, pattern) then return gmatch(subject, pattern, init) end
    local steps, from, last = compile(pattern, 1), first_from(init, #subject), nil
    return function()
        for begin = from, #subject + 1 do
            local stop, captures = try(steps, subject, begin)
            if stop and stop ~= last then
                from, last = stop, stop
                return results(subject, begin, stop, captures)
            end
        end
        from = #subject + 2
        return nil
    end
end

local function filled(template, whole, captures)
    return (gsub(template, "%%(.?)", function(mark)
        if mark == "0" then return whole end
        if mark == "%" then return "%" end
        local index = find(mark, "^%d$") and mark + 0
        if index == 1 and #captures == 0 then return whole end
        if not index or captures[index] == nil then error("invalid use of '%' in replacement string", 0) end
        return tostring(captures[index])
    end))
end

function world.string.gsub(subject, pattern, replacement, most)
    subject, pattern = texts(subject, pattern, "gsub")
    if is_quick(subject, pattern) and is_replaced_quickly(subject, replacement) then
        return gsub(subject, pattern, replacement, most)
    end
    local kind = type(replacement)
    if kind == "number" then replacement, kind = tostring(replacement), "string" end
    if kind ~= "string" and kind ~= "table" and kind ~= "function" then
        error("string.gsub: a replacement is a text, a table or a function", 2)
    end
    local anchored = byte(pattern, 1) == 94
    local steps = compile(pattern, anchored and 2 or 1)
    local parts, count, at, last, length = {}, 0, 1, nil, #subject
    while count < (most or length + 1) do
        local stop, captures = try(steps, subject, at)
        if stop and stop ~= last then
            count = count + 1
            local whole, value = sub(subject, at, stop - 1), nil
            if kind == "string" then value = filled(replacement, whole, captures)
            elseif kind == "table" then value = replacement[captures[1] == nil and whole or captures[1]]
            else value = replacement(results(subject, at, stop, captures)) end
            if value and type(value) ~= "string" and type(value) ~= "number" then
                error("invalid replacement value (a " .. type(value) .. ")", 2)
            end
            parts[#parts + 1] = value or whole
            at, last = stop, stop
        elseif at <= length then
            parts[#parts + 1] = sub(subject, at, at)
            at = at + 1
        else
            break
        end
        if anchored then break end
    end
    parts[#parts + 1] = sub(subject, at)
    return world.table.concat(parts), count
end

world.string.gfind = world.string.gmatch               -- the name of Lua 5.0, which 5.1 kept
