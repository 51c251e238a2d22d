-- Matrices, vectors, quaternions and poses of CoppeliaSim's API 2: Matrix, Vector, Quaternion, Pose.
--
-- Matrix and Vector are those of the module matrix-2. A quaternion is x, y, z, w; a pose x, y, z and a quaternion.

local linear = require("matrix-2")
local Matrix, Vector, Matrix3x3 = linear.Matrix, linear.Vector, linear.Matrix3x3
local is_matrix = require("linear.matrix").is_matrix

local Quaternion, Pose = {}, {}

local function new(class, data) return setmetatable({ _data = data }, class) end

local function numbers(value, count, what)
    if is_matrix(value) or getmetatable(value) == Quaternion or getmetatable(value) == Pose then value = value:data() end
    assert(type(value) == "table" and #value == count, what)
    local data = {}
    for i = 1, count do data[i] = value[i] + 0.0 end
    return data
end

local function class(kind, count, what)
    kind.__index = function(self, key)
        if math.type(key) == "integer" then return self._data[key] end
        local getter = kind.getters and kind.getters[key]
        if getter then return getter(self) end
        return kind[key]
    end
    kind.__newindex = function(self, key, value)
        assert(not self._frozen, "it is frozen: a copy can be changed")
        assert(math.type(key) == "integer" and key >= 1 and key <= count, "no such element")
        self._data[key] = value + 0.0
    end
    kind.__len = function() return count end
    kind.__eq = function(a, b)
        for i = 1, count do if a._data[i] ~= b._data[i] then return false end end
        return true
    end
    function kind:data() return table.move(self._data, 1, count, 1, {}) end
    function kind:totable() return self:data() end
    function kind:copy() return new(kind, self:data()) end
    function kind:freeze()
        rawset(self, "_frozen", true)
        return self
    end
    function kind:isfrozen() return rawget(self, "_frozen") == true end
    function kind:__tostring() return what .. "{" .. table.concat(self._data, ", ") .. "}" end
end

class(Quaternion, 4, "Quaternion")
class(Pose, 7, "Pose")

-- Quaternions.

setmetatable(Quaternion, { __call = function(_, value, ...)
    if value == nil then return new(Quaternion, { 0.0, 0.0, 0.0, 1.0 }) end
    if type(value) == "number" then value = { value, ... } end
    if is_matrix(value) and value:rows() == 3 and value:cols() == 3 then
        return new(Quaternion, numbers(Matrix3x3:toquaternion(value), 4, "a quaternion"))
    end
    return new(Quaternion, numbers(value, 4, "a quaternion is made of four numbers, x, y, z, w"))
end })

Quaternion.getters = {
    x = function(self) return self._data[1] end, y = function(self) return self._data[2] end,
    z = function(self) return self._data[3] end, w = function(self) return self._data[4] end,
}

function Quaternion.fromeuler(self, angles)
    return Quaternion(Matrix3x3:fromeuler(angles or self))
end

function Quaternion.fromaxisangle(self, axis, angle)
    if angle == nil then axis, angle = self, axis end
    if not is_matrix(axis) then axis = Vector(axis) end
    return Quaternion(Matrix3x3:fromaxisangle(axis, angle))
end

function Quaternion.random() return require("sim-2").app.randomQuaternion:copy() end

function Quaternion:norm()
    local x, y, z, w = table.unpack(self._data)
    return math.sqrt(x * x + y * y + z * z + w * w)
end

function Quaternion:normalized()
    local norm, data = self:norm(), {}
    for i = 1, 4 do data[i] = self._data[i] / norm end
    return new(Quaternion, data)
end

function Quaternion:inv()
    local x, y, z, w = table.unpack(self:normalized()._data)
    return new(Quaternion, { -x, -y, -z, w })
end

function Quaternion:tomatrix() return Matrix3x3:fromquaternion(self._data) end
function Quaternion:toeuler() return Matrix3x3:toeuler(self:tomatrix(), Matrix) end

function Quaternion.__mul(a, b)
    if is_matrix(b) then return a:tomatrix() * b end
    local x, y, z, w = table.unpack(a._data)
    local i, j, k, r = table.unpack(b._data)
    return new(Quaternion, {
        w * i + x * r + y * k - z * j, w * j - x * k + y * r + z * i,
        w * k + x * j - y * i + z * r, w * r - x * i - y * j - z * k,
    })
end

-- Poses.

setmetatable(Pose, { __call = function(_, value, turn)
    if value == nil then return new(Pose, { 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0 }) end
    if turn ~= nil then
        local data = numbers(value, 3, "a position is three numbers")
        table.move(Quaternion(turn)._data, 1, 4, 4, data)
        return new(Pose, data)
    end
    if is_matrix(value) and value:rows() == 4 and value:cols() == 4 then
        return Pose({ value:item(1, 4), value:item(2, 4), value:item(3, 4) }, value:slice(1, 1, 3, 3))
    end
    return new(Pose, numbers(value, 7, "a pose is made of seven numbers, x, y, z and a quaternion"))
end })

local function position(self) return Vector { self._data[1], self._data[2], self._data[3] } end
local function turn(self)
    return new(Quaternion, { self._data[4], self._data[5], self._data[6], self._data[7] })
end

Pose.getters = { t = position, q = turn, position = position, quaternion = turn }

function Pose:inv()
    local back = self.q:inv()
    return Pose((back * self.t) * -1, back)
end

function Pose:tomatrix()
    local whole = Matrix:eye(4)
    whole:assign(1, 1, self.q:tomatrix())
    whole:assign(1, 4, self.t)
    return whole
end

function Pose.__mul(a, b)
    if getmetatable(b) == Pose then return Pose(a.q * b.t + a.t, a.q * b.q) end
    return a.q * b + a.t
end

return {
    Matrix = Matrix, Vector = Vector, Quaternion = Quaternion, Pose = Pose, ismatrix = is_matrix,
    isquaternion = function(value) return getmetatable(value) == Quaternion end,
    ispose = function(value) return getmetatable(value) == Pose end,
}
