-- Functions of the API that only calculate, in Lua itself: Python's take five times as long.
--
-- The steps and their order are those of `sim_api/values/matrices.py` and `scene/poses`, so the results are the same to
-- the last bit; tests/server/scripting/lua/test_lua_arithmetic.py holds both equal. Each function returns nil unless its
-- arguments are lists of as many finite numbers as it needs, and for what is an error: then Python's is called.

local metatable, next, rawlen, sqrt, type, unpack, mathtype = debug.getmetatable, next, rawlen, math.sqrt, type,
    table.unpack, math.type

local OFF <const> = 1e-2                                        -- `_OFF_ROTATION` of `scene/poses/frames.py`

-- Whether a value is a list of as many finite numbers.
local function is_list(list, count)
    if type(list) ~= "table" or metatable(list) or rawlen(list) ~= count or next(list, count) ~= nil then
        return false
    end
    local sum = 0.0
    for i = 1, count do
        local item = list[i]
        if not mathtype(item) then return false end
        sum = sum + item
    end
    return sum - sum == 0.0                                     -- an infinite one, and none at all, would stay
end

-- The numbers of a matrix as floats; a float stays what it is, -0.0 too.
local function numbers(a, b, c, x, d, e, f, y, g, h, i, z)
    return a * 1.0, b * 1.0, c * 1.0, x * 1.0, d * 1.0, e * 1.0, f * 1.0, y * 1.0, g * 1.0, h * 1.0, i * 1.0, z * 1.0
end

-- The quaternion of a matrix's rotation; nil if its columns are not perpendicular unit vectors.
local function quaternion(a, b, c, d, e, f, g, h, i)
    local first, second, third = a * a + d * d + g * g - 1.0, b * b + e * e + h * h - 1.0, c * c + f * f + i * i - 1.0
    local fourth, fifth, sixth = a * b + d * e + g * h, a * c + d * f + g * i, b * c + e * f + h * i
    if not (first <= OFF and first >= -OFF and second <= OFF and second >= -OFF and third <= OFF and third >= -OFF
        and fourth <= OFF and fourth >= -OFF and fifth <= OFF and fifth >= -OFF and sixth <= OFF and sixth >= -OFF) then
        return nil
    end
    local w, x, y, z = 1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i
    if w >= x and w >= y and w >= z then
        x, y, z = h - f, c - g, d - b
    elseif x >= y and x >= z then
        w, y, z = h - f, b + d, c + g
    elseif y >= z then
        w, x, z = c - g, b + d, f + h
    else
        w, x, y = d - b, c + g, f + h
    end
    local length = sqrt(w * w + x * x + y * y + z * z)
    return w / length, x / length, y / length, z / length
end

-- A point in the frame of a pose, in which the pose is given in.
local function moved(px, py, pz, w, x, y, z, vx, vy, vz)
    local tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return px + (vx + w * tx + y * tz - z * ty), py + (vy + w * ty + z * tx - x * tz), pz + (vz + w * tz + x * ty - y * tx)
end

local function multiply_vector(matrix, point)
    if not is_list(matrix, 12) or not is_list(point, 3) then return nil end
    local a, b, c, px, d, e, f, py, g, h, i, pz = numbers(unpack(matrix, 1, 12))
    local w, x, y, z = quaternion(a, b, c, d, e, f, g, h, i)
    if not w then return nil end
    px, py, pz = moved(px, py, pz, w, x, y, z, point[1] * 1.0, point[2] * 1.0, point[3] * 1.0)
    return { px, py, pz, nil }                                  -- with places as in `builder` of `values.lua`
end

local function multiply_matrices(first, second)
    if not is_list(first, 12) or not is_list(second, 12) then return nil end
    local a, b, c, px, d, e, f, py, g, h, i, pz = numbers(unpack(first, 1, 12))
    local aw, ax, ay, az = quaternion(a, b, c, d, e, f, g, h, i)
    local vx, vy, vz
    a, b, c, vx, d, e, f, vy, g, h, i, vz = numbers(unpack(second, 1, 12))
    local bw, bx, by, bz = quaternion(a, b, c, d, e, f, g, h, i)
    if not aw or not bw then return nil end
    px, py, pz = moved(px, py, pz, aw, ax, ay, az, vx, vy, vz)
    local w, x = aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by
    local y, z = aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw
    return {
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), px,
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), py,
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), pz, nil, nil, nil, nil,
    }
end

return { ["sim.multiplyVector"] = multiply_vector, ["sim.multiplyMatrices"] = multiply_matrices }
