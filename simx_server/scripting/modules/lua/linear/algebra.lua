-- Linear algebra of matrices: products, vectors, elimination, inverse, homogeneous coordinates.

local matrix = require("linear.matrix")
local Matrix = matrix.Matrix

function Matrix:mul(other)
    if type(other) == "number" then return self:times(other) end
    assert(matrix.is_matrix(other), "the other factor is neither a matrix nor a number")
    assert(self._cols == other._rows, "the left matrix needs as many columns as the right one has rows")
    return Matrix(self._rows, other._cols, function(i, j)
        local sum = 0
        for k = 1, self._cols do sum = sum + self:item(i, k) * other:item(k, j) end
        return sum
    end)
end

function Matrix:power(exponent)
    assert(self._rows == self._cols and math.type(exponent) == "integer" and exponent >= 0,
        "only square matrices have powers, with whole exponents from 0 on")
    local found = Matrix:eye(self._rows)
    for _ = 1, exponent do found = found * self end
    return found
end

function Matrix:dot(other)
    local is_vector = self._rows == 1 or self._cols == 1
    assert(is_vector and self:sameshape(other), "only vectors of one size have a dot product")
    return self:times(other):sum()
end

function Matrix:cross(other)
    assert(self:count() == 3 and self:sameshape(other), "only vectors of three elements have a cross product")
    local a, b = self:data(), other:data()
    return Matrix(self._rows, self._cols,
        { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] })
end

function Matrix:kron(other)
    return Matrix(self._rows * other._rows, self._cols * other._cols, function(i, j)
        local row, col = (i - 1) // other._rows, (j - 1) // other._cols
        return self:item(row + 1, col + 1) * other:item(i - row * other._rows, j - col * other._cols)
    end)
end

function Matrix:norm() return math.sqrt(self:dot(self)) end
function Matrix:normalized() return self / self:norm() end

function Matrix:trace()
    assert(self._rows == self._cols, "only square matrices have a trace")
    return self:diag():sum()
end

-- Return the row echelon form, with `jordan` the reduced one, and the determinant of the square part.
function Matrix:gauss(jordan)
    local work, determinant = self:copy(), 1
    for k = 1, work._rows do
        local best = k
        for i = k + 1, work._rows do
            if math.abs(work:item(i, k)) > math.abs(work:item(best, k)) then best = i end
        end
        local pivot = work:item(best, k)
        if pivot == 0 then return work, 0 end
        if best ~= k then
            local row = work:row(k)
            work:setrow(k, work:row(best)):setrow(best, row)
            determinant = -determinant
        end
        determinant = determinant * pivot
        if jordan then work:setrow(k, work:row(k) / pivot) end
        for i = jordan and 1 or k + 1, work._rows do
            local factor = i ~= k and work:item(i, k) / work:item(k, k) or 0
            if factor ~= 0 then work:setrow(i, work:row(i) - work:row(k) * factor) end
        end
    end
    return work, determinant
end

function Matrix:det()
    assert(self._rows == self._cols, "only square matrices have a determinant")
    return (select(2, self:gauss()))
end

function Matrix:inv()
    local size = self._rows
    assert(size == self._cols, "only square matrices have an inverse")
    local work, determinant = self:horzcat(Matrix:eye(size)):gauss(true)
    if math.abs(determinant) < 1e-11 then error("the matrix has no inverse", 2) end
    return work:slice(1, size + 1, size, 2 * size)
end

-- The pseudo-inverse; with `right` also the x with the smallest error of self * x = right.
function Matrix:pinv(right, damping)
    local transposed, square = self:t(), (damping or 0) ^ 2
    local inverse
    if self._rows >= self._cols then
        inverse = (transposed * self + Matrix:eye(self._cols) * square):inv() * transposed
    else
        inverse = transposed * (self * transposed + Matrix:eye(self._rows) * square):inv()
    end
    return inverse, right and inverse * right
end

-- Homogeneous coordinates.

function Matrix:hom()
    assert(self._rows == 3, "a matrix of three rows is needed")
    return self:vertcat(Matrix:ones(1, self._cols))
end

function Matrix:nonhom()
    assert(self._rows == 4, "a matrix of four rows is needed")
    return Matrix(3, self._cols, function(i, j) return self:item(i, j) / self:item(4, j) end)
end

function Matrix:mult(vector) return (self * vector:hom()):nonhom() end

function Matrix:axis(which)
    local column = ({ x = 1, y = 2, z = 3, 1, 2, 3 })[which]
    return self:slice(1, column, 3, column)
end
