"""Inverse kinematics by least squares, in two forms: Python (`in_python`, `rows`, `steps`) and C (`native`).

`problem` has the arrays that both take, `form` says what both do and chooses one. Results are equal bit for bit: sums
are written out in the order in which they are added, and libraries of linear algebra, whose order depends on the
machine, take no part. A formula that changes in one form changes in the other.
"""
