-- Checks the arguments of a function against a list of descriptions, and fills in default values.
--
--     local name, size = checkargs({{type = 'string'}, {type = 'float', default = 1}}, ...)
--
-- A default of NIL is nil. Further keys: nullable, item_type and size of a table ('3' or '1..*'), union (a list).

NIL = NIL or {}

local KINDS = { bool = "boolean", string = "string", table = "table", func = "function", buffer = "string" }

local check

local function size_fits(count, size)
    if math.type(size) == "integer" or tonumber(size) then return count == tonumber(size) end
    local least, most = string.match(size, "^(%d+)%.%.([%d*]+)$")
    return not least or (count >= tonumber(least) and (most == "*" or count <= tonumber(most)))
end

local function table_problem(value, description)
    if description.size and not size_fits(#value, description.size) then
        return "must have " .. description.size .. " elements, and has " .. #value
    end
    for i = 1, description.item_type and #value or 0 do
        local problem = check(value[i], { type = description.item_type })
        if problem then return "element " .. i .. " " .. problem end
    end
end

function check(value, description)
    if description.union then
        for _, each in ipairs(description.union) do
            if not check(value, each) then return nil end
        end
        return "has none of the possible types"
    end
    local kind = description.type
    if kind == nil or kind == "any" or (value == nil and description.nullable) then return nil end
    if kind == "int" or kind == "handle" then
        return not (type(value) == "number" and value == math.floor(value)) and "must be a whole number" or nil
    end
    if kind == "float" or kind == "number" then return type(value) ~= "number" and "must be a number" or nil end
    local wanted = KINDS[kind] or "table"
    if type(value) ~= wanted then return "must be a " .. wanted .. ", not a " .. type(value) end
    return wanted == "table" and table_problem(value, description) or nil
end

function checkargsEx(options, descriptions, ...)
    local values, level = table.pack(...), 2 + (options.level or 0)
    if values.n > #descriptions then
        error("at most " .. #descriptions .. " arguments expected, got " .. values.n, level)
    end
    for i, description in ipairs(descriptions) do
        if i > values.n or (values[i] == nil and description.default_nil_fallback) then
            if description.default == nil and not description.nullable then
                error("at least " .. i .. " arguments expected, got " .. values.n, level)
            end
            values[i] = description.default
            if values[i] == NIL then values[i] = nil end
        else
            local problem = check(values[i], description)
            if problem then error("argument " .. i .. " " .. problem, level) end
        end
    end
    return table.unpack(values, 1, #descriptions)
end

function checkargs(descriptions, ...) return checkargsEx({ level = 1 }, descriptions, ...) end

return { checkargs = checkargs, checkargsEx = checkargsEx, NIL = NIL }
