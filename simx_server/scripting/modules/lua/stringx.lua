-- Functions that CoppeliaSim adds to Lua's string; those that a script has defined stay.

local find, sub, match, byte, gsub, rep = string.find, string.sub, string.match, string.byte, string.gsub, string.rep
local added = {}

local ENTITIES = { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;", ['"'] = "&quot;", ["'"] = "&#39;" }

function added.gsplit(text, separator, plain)
    local start = 1
    return function()
        if not start then return nil end
        local first, last = find(text, separator, start, plain)
        local piece
        if not first then
            piece, start = sub(text, start), nil
        elseif last < first then                                        -- an empty separator: each character
            piece = sub(text, start, first)
            start = first < #text and first + 1 or nil
        else
            piece, start = sub(text, start, first - 1), last + 1
        end
        return piece
    end
end

function added.split(text, separator, plain)
    local found = {}
    for piece in added.gsplit(text, separator, plain) do found[#found + 1] = piece end
    return found
end

-- The lines of a text.
function added.splitlines(text) return added.split(text, "\r?\n") end

-- As split, but a separator within quotes does not count, and empty pieces are left out.
function added.qsplit(text, separator)
    local found, piece, quote, place = {}, "", nil, 1
    while place <= #text do
        local first, last = find(text, separator, place)
        if first == place and last >= first and not quote then
            if piece ~= "" then found[#found + 1] = piece end
            piece, place = "", last + 1
        else
            local letter = sub(text, place, place)
            if letter == quote then quote = nil
            elseif not quote and (letter == '"' or letter == "'") then quote = letter end
            piece, place = piece .. letter, place + 1
        end
    end
    if piece ~= "" then found[#found + 1] = piece end
    return found
end

function added.startswith(text, start) return sub(text, 1, #start) == start end
function added.endswith(text, ending) return ending == "" or sub(text, -#ending) == ending end
function added.stripprefix(text, start) return added.startswith(text, start) and sub(text, #start + 1) or text end
function added.stripsuffix(text, ending) return added.endswith(text, ending) and sub(text, 1, -#ending - 1) or text end
function added.ltrim(text) return match(text, "^%s*(.*)$") end
function added.trim(text) return added.rtrim(added.ltrim(text)) end

function added.rtrim(text)
    local last = #text
    while last > 0 and find(text, "^%s", last) do last = last - 1 end
    return sub(text, 1, last)
end

function added.chars(text)
    local found = {}
    for i = 1, #text do found[i] = sub(text, i, i) end
    return found
end

function added.bytes(text)
    local found = {}
    for i = 1, #text do found[i] = byte(text, i) end
    return found
end

-- The pattern that means the text itself.
function added.escpat(text) return (gsub(text, "[%^%$%(%)%%%.%[%]%*%+%-%?]", "%%%0")) end

for name, class in pairs { isalnum = "%w*", isalpha = "%a*", isnumeric = "%d*", isspace = "%s*",
    isidentifier = "[_%a][_%w]*" } do
    added[name] = function(text) return match(text, "^" .. class .. "$") end
end

function added.islower(text) return string.lower(text) == text end
function added.isupper(text) return string.upper(text) == text end
function added.isprintable(text) return utf8.len(text) ~= nil and not find(text, "%c") end
function added.capitalize(text) return string.upper(sub(text, 1, 1)) .. sub(text, 2) end

function added.escapequotes(text, quote) return (gsub(gsub(text, "\\", "\\\\"), quote or "'", "\\%0")) end

function added.escapehtml(text)
    return (gsub(text, "[&<>\"']", ENTITIES))
end

function added.elide(text, most)
    return #text > (most or 80) and sub(text, 1, most or 80) .. "..." or text
end

function added.utf8sub(text, first, last)
    local stop = last and utf8.offset(text, last + 1)
    return sub(text, utf8.offset(text, first) or #text + 1, stop and stop - 1 or #text)
end

-- Fill a text with spaces to a width: behind it, in front of it where the width is negative.
function added.pad(text, width, is_cut)
    local size = math.abs(width)
    if is_cut then text = added.utf8sub(text, 1, size) end
    local space = rep(" ", size - (utf8.len(text) or #text))
    return width < 0 and space .. text or text .. space
end

-- string.format, in which tables and other values are texts.
function added.formatex(pattern, ...)
    local values = table.pack(...)
    for i = 1, values.n do
        local kind = type(values[i])
        if kind ~= "string" and kind ~= "number" then values[i] = getAsString(values[i]) end
    end
    return string.format(pattern, table.unpack(values, 1, values.n))
end

for name, action in pairs(added) do
    if rawget(string, name) == nil then string[name] = action end
end

return added
