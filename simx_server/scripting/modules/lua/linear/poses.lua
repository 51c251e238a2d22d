-- Rotation matrices and homogeneous transformations. Angles are in radians; a quaternion is x, y, z, w; Euler
-- angles are the simulator's: rotations about x, then the new y, then the new z.

local matrix, vectors = require("linear.matrix"), require("linear.vectors")
local Matrix, Vector3, Vector4, Vector7 = matrix.Matrix, vectors.Vector3, vectors.Vector4, vectors.Vector7

local Matrix3x3 = setmetatable({}, { __call = function(_, data) return Matrix(3, 3, data) end })
local Matrix4x4 = setmetatable({}, { __call = function(_, data)
    local is_short = type(data) == "table" and #data == 12                  -- as sim.getObjectMatrix returns it
    return is_short and Matrix(3, 4, data):vertcat(Matrix(1, 4, { 0, 0, 0, 1 })) or Matrix(4, 4, data)
end })

local function values_of(given, ...)
    local values = {}
    for i, name in ipairs { ... } do values[i] = given[i] or given[name] end
    return table.unpack(values)
end

local function given_as(kind, constructor, values) return kind == Matrix and constructor(values) or values end

function Matrix3x3.rotx(_, angle)
    local s, c = math.sin(angle), math.cos(angle)
    return Matrix3x3 { 1, 0, 0, 0, c, -s, 0, s, c }
end

function Matrix3x3.roty(_, angle)
    local s, c = math.sin(angle), math.cos(angle)
    return Matrix3x3 { c, 0, s, 0, 1, 0, -s, 0, c }
end

function Matrix3x3.rotz(_, angle)
    local s, c = math.sin(angle), math.cos(angle)
    return Matrix3x3 { c, -s, 0, s, c, 0, 0, 0, 1 }
end

function Matrix3x3.fromquaternion(_, quaternion)
    local x, y, z, w = values_of(quaternion, "x", "y", "z", "w")
    local k = 2 / (x * x + y * y + z * z + w * w)
    return Matrix3x3 {
        1 - k * (y * y + z * z), k * (x * y - z * w), k * (x * z + y * w),
        k * (x * y + z * w), 1 - k * (x * x + z * z), k * (y * z - x * w),
        k * (x * z - y * w), k * (y * z + x * w), 1 - k * (x * x + y * y),
    }
end

function Matrix3x3.fromeuler(_, angles)
    local x, y, z = values_of(angles, "x", "y", "z")
    return Matrix3x3:rotx(x) * Matrix3x3:roty(y) * Matrix3x3:rotz(z)
end

function Matrix3x3.fromaxisangle(_, axis, angle)
    local unit, s = axis:normalized(), math.sin(angle / 2)
    return Matrix3x3:fromquaternion { unit[1] * s, unit[2] * s, unit[3] * s, math.cos(angle / 2) }
end

-- The greatest of the four components is found first, so that the divisor is not small.
function Matrix3x3.toquaternion(_, m, kind)
    local trace, q = m:trace(), {}
    local greatest = 1
    for i = 2, 3 do
        if m:item(i, i) > m:item(greatest, greatest) then greatest = i end
    end
    local a, b, c = greatest, greatest % 3 + 1, (greatest + 1) % 3 + 1
    if trace > 0 then
        local s = 2 * math.sqrt(trace + 1)
        q = { (m:item(3, 2) - m:item(2, 3)) / s, (m:item(1, 3) - m:item(3, 1)) / s,
            (m:item(2, 1) - m:item(1, 2)) / s, s / 4 }
    else
        local s = 2 * math.sqrt(1 + m:item(a, a) - m:item(b, b) - m:item(c, c))
        q[a], q[4] = s / 4, (m:item(c, b) - m:item(b, c)) / s
        q[b], q[c] = (m:item(a, b) + m:item(b, a)) / s, (m:item(a, c) + m:item(c, a)) / s
    end
    return given_as(kind, Vector4, q)
end

-- As CoppeliaSim returns them: roll, pitch and yaw about fixed axes, and so not what `fromeuler` takes.
function Matrix3x3.toeuler(_, m, kind)
    local across = math.sqrt(m:item(3, 2) ^ 2 + m:item(3, 3) ^ 2)
    return given_as(kind, Vector3, {
        math.atan(m:item(3, 2), m:item(3, 3)), math.atan(-m:item(3, 1), across), math.atan(m:item(2, 1), m:item(1, 1)),
    })
end

function Matrix3x3.random() return Matrix3x3:fromaxisangle(Vector3:unitrandom(), math.random() * math.pi * 2) end

function Matrix3x3.isorthonormal(_, m, tolerance)
    return (m:t() * m - Matrix:eye(3)):abs():max() <= (tolerance or 1e-5)
end

function Matrix4x4.fromrt(_, rotation, translation)
    return Matrix:eye(4):assign(1, 1, rotation):assign(1, 4, translation)
end

function Matrix4x4.fromrotation(_, rotation) return Matrix4x4:fromrt(rotation, Vector3()) end
function Matrix4x4.fromquaternion(_, q) return Matrix4x4:fromrotation(Matrix3x3:fromquaternion(q)) end
function Matrix4x4.fromeuler(_, angles) return Matrix4x4:fromrotation(Matrix3x3:fromeuler(angles)) end
function Matrix4x4.fromposition(_, p) return Matrix4x4:fromrt(Matrix:eye(3), Vector3 { p[1], p[2], p[3] }) end

function Matrix4x4.frompose(_, pose)
    local rotation = Matrix3x3:fromquaternion { pose[4], pose[5], pose[6], pose[7] }
    return Matrix4x4:fromrt(rotation, Vector3 { pose[1], pose[2], pose[3] })
end

function Matrix4x4.torotation(_, m) return m:slice(1, 1, 3, 3) end
function Matrix4x4.toquaternion(_, m, kind) return Matrix3x3:toquaternion(Matrix4x4:torotation(m), kind) end
function Matrix4x4.toeuler(_, m, kind) return Matrix3x3:toeuler(Matrix4x4:torotation(m), kind) end
function Matrix4x4.toposition(_, m, kind) return given_as(kind, Vector3, m:slice(1, 4, 3, 4):data()) end

function Matrix4x4.topose(_, m, kind)
    local pose = Matrix4x4:toposition(m)
    table.move(Matrix4x4:toquaternion(m), 1, 4, 4, pose)
    return given_as(kind, Vector7, pose)
end

function Matrix4x4.inv(_, m)
    local rotation = Matrix4x4:torotation(m):t()
    return Matrix4x4:fromrt(rotation, -(rotation * m:slice(1, 4, 3, 4)))
end

function Matrix4x4.random() return Matrix4x4:fromrt(Matrix3x3:random(), Vector3:random()) end

return { Matrix3x3 = Matrix3x3, Matrix4x4 = Matrix4x4 }
