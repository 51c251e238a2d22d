-- Constructors of vectors, which are matrices of one column.

local matrix = require("linear.matrix")
local Matrix = matrix.Matrix

local function constructor(size)
    return setmetatable({}, { __call = function(_, data) return Matrix(size, 1, data) end })
end

local Vector, Vector3, Vector4 = {}, constructor(3), constructor(4)

setmetatable(Vector, { __call = function(_, size, data)
    if type(size) == "table" then size, data = #size, size end
    return Matrix(size, 1, data)
end })

function Vector.range(_, start, stop, step)
    if not stop then start, stop = 1, start end
    local values = {}
    for value = start, stop, step or 1 do values[#values + 1] = value end
    return Vector(values)
end

-- Return `count` values, and the distance between two of them.
function Vector.linspace(_, start, stop, count, endpoint)
    count = count or 50
    local step = (stop - start) / (endpoint == false and count or count - 1)
    return Vector(count, function(i) return start + (i - 1) * step end), step
end

function Vector.logspace(_, start, stop, count, endpoint, base)
    return (base or 10.0) ^ Vector:linspace(start, stop, count, endpoint)
end

function Vector.geomspace(_, start, stop, count, endpoint)
    local ratio = (stop / start) ^ (1 / (count - 1))
    return start * ratio ^ Vector:linspace(0, count - 1, count, endpoint)
end

function Vector3.hom(_, vector) return Vector4 { vector[1], vector[2], vector[3], 1.0 } end

function Vector3.random() return Vector3(function() return math.tan((math.random() - 0.5) * 1.98 * math.pi) end) end

function Vector3.unitrandom()
    local polar, azimuth = math.random() * math.pi, math.random() * math.pi * 2
    return Vector3 { math.sin(polar) * math.cos(azimuth), math.sin(polar) * math.sin(azimuth), math.cos(polar) }
end

function Vector4.hom(_, v) return Vector4 { v[1] / v[4], v[2] / v[4], v[3] / v[4], 1.0 } end

return { Vector = Vector, Vector3 = Vector3, Vector4 = Vector4, Vector7 = constructor(7) }
