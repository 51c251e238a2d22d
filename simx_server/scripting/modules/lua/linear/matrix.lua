-- Matrices and vectors with operators, as CoppeliaSim"s scripts use them: Matrix, Vector, Vector3, Vector4,
-- Vector7, Matrix3x3, Matrix4x4. A vector is a matrix of one column. Elements are kept row by row.

local Matrix = {}
local make

local function is_matrix(value) return getmetatable(value) == Matrix end

local function same_shape(a, b)
    assert(a._rows == b._rows and a._cols == b._cols, "the shapes of the matrices differ")
end

function Matrix:rows() return self._rows end
function Matrix:cols() return self._cols end
function Matrix:count() return self._rows * self._cols end

function Matrix:sameshape(rows, cols)
    if is_matrix(rows) then rows, cols = rows._rows, rows._cols
    elseif type(rows) == "table" then rows, cols = rows[1], rows[2] end
    return self._rows == rows and self._cols == cols
end

-- Elements: by row and column, or by one number, row by row.

function Matrix:offset(i, j)
    if not j then return i >= 1 and i <= self:count() and i or nil end
    if i < 1 or j < 1 or i > self._rows or j > self._cols then return nil end
    return self._cols * (i - 1) + j
end

function Matrix:item(i, j)
    local place = self:offset(i, j)
    return place and self._data[place]
end

function Matrix:setitem(i, j, value)
    assert(not rawget(self, "_frozen"), "the matrix is frozen: a copy can be changed")
    local place = self:offset(i, j)
    if place then self._data[place] = value end
    return self
end

Matrix.get, Matrix.set = Matrix.item, Matrix.setitem

function Matrix:data() return table.move(self._data, 1, self:count(), 1, {}) end
function Matrix:dataref() return self._data end
function Matrix:copy() return make(self._rows, self._cols, self:data()) end

function Matrix:slice(top, left, bottom, right)
    return Matrix(bottom - top + 1, right - left + 1, function(i, j)
        return self:item(top + i - 1, left + j - 1) or 0
    end)
end

function Matrix:assign(top, left, other)
    for i = 1, other._rows do
        for j = 1, other._cols do self:setitem(top + i - 1, left + j - 1, other:item(i, j)) end
    end
    return self
end

function Matrix:block(top, left, rows, cols) return self:slice(top, left, top + rows - 1, left + cols - 1) end

function Matrix:freeze()
    rawset(self, "_frozen", true)
    return self
end

function Matrix:isfrozen() return rawget(self, "_frozen") == true end

function Matrix:row(i) return self:slice(i, 1, i, self._cols) end
function Matrix:col(j) return self:slice(1, j, self._rows, j) end

-- A row whose elements are those of the matrix itself.
function Matrix:rowref(i)
    local place = setmetatable({}, {
        __index = function(_, j) return self:item(i, j) end,
        __newindex = function(_, j, value) self:setitem(i, j, value) end,
        __len = function() return self._cols end,
    })
    return make(1, self._cols, place)
end

local function values_of(line, count)
    return is_matrix(line) and line:data() or assert(type(line) == "table" and line, "a row or column is a table")
end

function Matrix:setrow(i, line)
    local values = values_of(line)
    for j = 1, self._cols do self:setitem(i, j, values[j] or 0) end
    return self
end

function Matrix:setcol(j, line)
    local values = values_of(line)
    for i = 1, self._rows do self:setitem(i, j, values[i] or 0) end
    return self
end

function Matrix:droprow(i)
    return Matrix(self._rows - 1, self._cols, function(k, j) return self:item(k < i and k or k + 1, j) end)
end

function Matrix:dropcol(j)
    return Matrix(self._rows, self._cols - 1, function(i, k) return self:item(i, k < j and k or k + 1) end)
end

function Matrix:flip(dimension)
    if dimension == 2 then
        return self:applyfuncidx(function(i, j) return self:item(i, self._cols - j + 1) end)
    end
    return self:applyfuncidx(function(i, j) return self:item(self._rows - i + 1, j) end)
end

function Matrix:repmat(down, across)
    return Matrix(self._rows * down, self._cols * (across or 1), function(i, j)
        return self:item((i - 1) % self._rows + 1, (j - 1) % self._cols + 1)
    end)
end

function Matrix:at(rows, cols) return rows:applyfunc2(cols, function(i, j) return self:item(i, j) end) end
function Matrix:t() return Matrix(self._cols, self._rows, function(i, j) return self:item(j, i) end) end

local function joined(parts, is_across)
    if not is_matrix(parts[1]) then table.remove(parts, 1) end          -- called as Matrix:horzcat(...)
    local rows, cols = 0, 0
    for _, part in ipairs(parts) do
        rows = is_across and part._rows or rows + part._rows
        cols = is_across and cols + part._cols or part._cols
    end
    local whole, place = Matrix(rows, cols), 1
    for _, part in ipairs(parts) do
        assert((is_across and part._rows == rows) or (not is_across and part._cols == cols), "the sizes differ")
        whole:assign(is_across and 1 or place, is_across and place or 1, part)
        place = place + (is_across and part._cols or part._rows)
    end
    return whole
end

function Matrix.horzcat(...) return joined({...}, true) end
function Matrix.vertcat(...) return joined({...}, false) end

-- Functions of each element.

function Matrix:applyfuncidx(action)
    return Matrix(self._rows, self._cols, function(i, j) return action(i, j, self:item(i, j)) end)
end

function Matrix:applyfunc(action) return self:applyfuncidx(function(_, _, x) return action(x) end) end

function Matrix:applyfunc2(other, action)
    same_shape(self, other)
    return self:applyfuncidx(function(i, j, x) return action(x, other:item(i, j)) end)
end

function Matrix:binop(other, action)
    if is_matrix(other) then return self:applyfunc2(other, action) end
    assert(type(other) == "number", "the other operand is neither a matrix nor a number")
    return self:applyfunc(function(x) return action(x, other) end)
end

for _, name in ipairs{"abs", "acos", "asin", "ceil", "cos", "deg", "exp", "floor", "rad", "sin", "sqrt", "tan",
                      "tointeger"} do
    Matrix[name] = function(self) return self:applyfunc(math[name]) end
end
for _, name in ipairs{"atan", "log"} do
    Matrix[name] = function(self, other)
        if other == nil then return self:applyfunc(math[name]) end
        return self:binop(other, math[name])
    end
end
for name, action in pairs{
    add = function(a, b) return a + b end, sub = function(a, b) return a - b end,
    times = function(a, b) return a * b end, div = function(a, b) return a / b end,
    idiv = function(a, b) return a // b end, mod = function(a, b) return a % b end,
    pow = function(a, b) return a ^ b end, fmod = math.fmod, ult = math.ult,
    eq = function(a, b) return a == b and 1 or 0 end, ne = function(a, b) return a ~= b and 1 or 0 end,
    lt = function(a, b) return a < b and 1 or 0 end, gt = function(a, b) return a > b and 1 or 0 end,
    le = function(a, b) return a <= b and 1 or 0 end, ge = function(a, b) return a >= b and 1 or 0 end,
} do
    Matrix[name] = function(self, other) return self:binop(other, action) end
end

function Matrix:random(...)
    local bounds = {...}
    return self:applyfunc(function() return math.random(table.unpack(bounds)) end)
end

-- Reductions: of all elements, of each column (1) or each row (2).

function Matrix:fold(dimension, start, action)
    if dimension == 1 then
        return Matrix(1, self._cols, function(_, j) return self:col(j):fold(nil, start, action) end)
    elseif dimension == 2 then
        return Matrix(self._rows, 1, function(i) return self:row(i):fold(nil, start, action) end)
    end
    local found = start
    for place = 1, self:count() do found = action(found, self._data[place]) end
    return found
end

function Matrix:sum(dimension) return self:fold(dimension, 0, function(a, b) return a + b end) end
function Matrix:prod(dimension) return self:fold(dimension, 1, function(a, b) return a * b end) end

function Matrix:mean(dimension)
    return self:sum(dimension) / (dimension == 1 and self._rows or dimension == 2 and self._cols or self:count())
end

for name, is_better in pairs{max = function(a, b) return a > b end, min = function(a, b) return a < b end} do
    Matrix[name] = function(self, other)
        if is_matrix(other) then return self:applyfunc2(other, math[name]) end
        if other then
            return self:fold(other, name == "max" and -math.huge or math.huge, math[name])
        end
        local best = 1
        for place = 2, self:count() do
            if is_better(self._data[place], self._data[best]) then best = place end
        end
        return self._data[best], (best - 1) // self._cols + 1, (best - 1) % self._cols + 1
    end
end

local function is_set(x) return x ~= 0 end

function Matrix:any(test)
    for place = 1, self:count() do
        if (test or is_set)(self._data[place]) then return true end
    end
    return false
end

function Matrix:all(test) return not self:any(function(x) return not (test or is_set)(x) end) end
function Matrix:isnan() return self:any(function(x) return x ~= x end) end

function Matrix:nonzero()
    local found = {}
    for i = 1, self._rows do
        for j = 1, self._cols do
            if self:item(i, j) ~= 0 then found[#found + 1] = {i, j} end
        end
    end
    return Matrix:fromtable(found)
end

function Matrix.where(_, condition, x, y)
    return condition:applyfuncidx(function(i, j, chosen) return (chosen ~= 0 and x or y):item(i, j) end)
end

-- Making matrices.

function make(rows, cols, data) return setmetatable({_rows = rows, _cols = cols, _data = data}, Matrix) end

setmetatable(Matrix, {__call = function(_, rows, cols, data)
    if type(rows) == "table" then return Matrix:fromtable(rows) end
    assert(math.type(rows) == "integer" and math.type(cols) == "integer", "rows and columns must be integers")
    if type(data) == "table" then
        if data.ref then return make(rows, cols, data.ref) end
        if rows == -1 then rows = #data // cols elseif cols == -1 then cols = #data // rows end
        assert(#data == rows * cols, "the number of elements is not rows times columns")
        return make(rows, cols, table.move(data, 1, #data, 1, {}))
    end
    local values = {}
    for i = 1, rows do
        for j = 1, cols do values[#values + 1] = data and data(i, j) or 0 end
    end
    return make(rows, cols, values)
end})

function Matrix.fromtable(_, values)
    if values.dims then return Matrix(values.dims[1], values.dims[2], values.data) end
    local flat, cols = {}, #values > 0 and #values[1] or 0
    for _, row in ipairs(values) do
        assert(#row == cols, "the rows have different lengths")
        table.move(row, 1, cols, #flat + 1, flat)
    end
    return make(#values, cols, flat)
end

function Matrix:totable(format)
    if format then return {dims = {self._rows, self._cols}, data = self:data()} end
    local rows = {}
    for i = 1, self._rows do rows[i] = self:row(i):data() end
    return rows
end

function Matrix.eye(_, size) return Matrix(size, size, function(i, j) return i == j and 1 or 0 end) end
function Matrix.ones(_, rows, cols) return Matrix(rows, cols, function() return 1 end) end
function Matrix.zeros(_, rows, cols) return Matrix(rows, cols) end

-- Of a matrix: its diagonal as a vector; Matrix:diag(values): the square matrix with this diagonal.
function Matrix:diag(values)
    if not values then
        return Matrix(math.min(self._rows, self._cols), 1, function(i) return self:item(i, i) end)
    end
    values = values_of(values)
    return Matrix(#values, #values, function(i, j) return i == j and values[i] or 0 end)
end

-- Operators.

local function swapped(name)
    return function(a, b)
        if is_matrix(a) then return a[name](a, b) end
        return b[name](b, a)
    end
end

Matrix.__add, Matrix.__mul = swapped("add"), swapped("mul")
function Matrix.__sub(a, b) return is_matrix(a) and a:sub(b) or b:mul(-1):add(a) end
function Matrix.__div(a, b) return a:div(b) end
function Matrix.__idiv(a, b) return a:idiv(b) end
function Matrix.__mod(a, b) return a:mod(b) end
function Matrix.__unm(a) return a:mul(-1) end
function Matrix.__eq(a, b) return a:sameshape(b) and a:eq(b):all() end
function Matrix.__concat(a, b) return a:dot(b) end

function Matrix.__pow(a, b)
    if type(a) == "number" then return b:applyfunc(function(x) return a ^ x end) end
    if type(b) == "number" then return a:power(b) end
    return a:cross(b)
end

function Matrix:__len() return self._rows == 1 and self._cols or self._rows end

function Matrix:__index(key)
    if key == "T" then return self:t() end
    if type(key) == "table" then return self:item(key[1], key[2]) end
    if type(key) ~= "number" then return Matrix[key] end
    if self._rows == 1 or self._cols == 1 then return self:item(key) end
    return self:rowref(key)
end

function Matrix:__newindex(key, value)
    if type(key) == "table" then
        self:setitem(key[1], key[2], value)
    elseif self._rows == 1 or self._cols == 1 then
        self:setitem(key, nil, value)
    else
        self:setrow(key, value)
    end
end

function Matrix:__tostring()
    local values = {}
    for place = 1, self:count() do values[place] = tostring(self._data[place]) end
    return "Matrix(" .. self._rows .. ", " .. self._cols .. ", {" .. table.concat(values, ", ") .. "})"
end

function Matrix:print(name)
    local start = name and name .. " = " or ""
    if self._cols == 1 then
        print(start .. "Vector{" .. table.concat(self:data(), ", ") .. "}")
        return
    end
    for i = 1, self._rows do
        local row = (i == 1 and start .. "Matrix{{" or (" "):rep(#start + 7) .. "{")
        print(row .. table.concat(self:row(i):data(), ", ") .. (i == self._rows and "}}" or "},"))
    end
end

return {Matrix = Matrix, is_matrix = is_matrix}
