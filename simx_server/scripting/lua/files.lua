-- Lua's io for scripts: files of the workspace to write, the log as the standard output, and nothing to read.
--
-- Arguments: the script's world, a function that returns the script's position, the function that receives a line,
-- the function that returns a member of a namespace.
-- The server's functions for files (`written_files.py`) are taken before the script can replace them.

local world, where, output, member = ...
local error, type, pcall, tostring, select, setmetatable = error, type, pcall, tostring, select, setmetatable
local match, gsub, concat, mathtype, metatable = string.match, string.gsub, table.concat, math.type, debug.getmetatable

local function refused(_, name)
    error(where() .. "io." .. tostring(name) .. ": scripts read no files; io.open writes files of the workspace", 0)
end

local io = {}
world.io = setmetatable(io, { __index = refused, __metatable = false })

local simx = world.simx
local open, write, flush, close
if simx then
    open, write, flush, close = member(simx, "openFile"), member(simx, "writeFile"), member(simx, "flushFile"),
        member(simx, "closeFile")
end
local File = {}
File.__index, File.__name, File.__metatable = File, "FILE*", false

local numbers, sizes = setmetatable({}, { __mode = "k" }), setmetatable({}, { __mode = "k" })

-- The result of a function of the server as Lua's io reports it.
local function result(value, ok, problem)
    if ok then return value end
    return nil, tostring(problem), 1
end

local function texts_of(...)
    local texts = { ... }
    for i = 1, select("#", ...) do
        local kind = type(texts[i])
        if kind ~= "string" and kind ~= "number" then
            error(where() .. "bad argument #" .. i .. " to 'write' (string expected, got " .. kind .. ")", 0)
        end
    end
    return concat(texts)
end

local function printed(...)
    local text = gsub(texts_of(...), "\n$", "")
    if text ~= "" then output(text) end
end

local function make(number)
    local file = setmetatable({}, File)
    numbers[file], sizes[file] = number, 0
    return file
end

function File:write(...)
    if numbers[self] == "output" then
        printed(...)
        return self
    end
    local text = texts_of(...)
    sizes[self] = sizes[self] + #text
    return result(self, pcall(write, numbers[self] or 0, text))
end

function File:flush()
    if numbers[self] == "output" then return self end
    return result(self, pcall(flush, numbers[self] or 0))
end

function File:close()
    local number = numbers[self]
    if number == "output" then return true end
    numbers[self] = nil
    return result(true, pcall(close, number or 0))
end

-- Only where the end is asked for: files grow at their end.
function File:seek(whence, offset)
    if (whence or "cur") ~= "set" and (offset or 0) == 0 then return sizes[self] end
    return nil, "scripts write at the end of files", 1
end

function File:setvbuf() return true end
function File:read() return nil, "scripts read no files", 1 end
function File:lines() refused(nil, "lines") end
function File:__tostring() return numbers[self] and "file" or "file (closed)" end

function io.open(path, mode)
    if type(path) ~= "string" then
        error(where() .. "bad argument #1 to 'open' (string expected, got " .. type(path) .. ")", 0)
    end
    local way = match(mode or "r", "^([wa])%+?b?%+?$")
    if not way or not open then
        return nil, path .. ": scripts read no files; modes w and a write files of the workspace", 2
    end
    local ok, number = pcall(open, path, way == "a")
    if not ok then return nil, path .. ": " .. tostring(number), 2 end
    return make(number)
end

io.stdout, io.stderr = make("output"), make("output")
io.write = printed

function io.output() return io.stdout end
function io.read() return nil end
function io.popen(command) return nil, tostring(command) .. ": scripts start no programs", 1 end
function io.tmpfile() return nil, "scripts have no temporary files", 1 end

function io.type(value)
    if type(value) ~= "table" or not sizes[value] then return nil end
    return numbers[value] and "file" or "closed file"
end

function io.close(file) return (file or io.stdout):close() end
