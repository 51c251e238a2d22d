-- CoppeliaSim's matrices and vectors, as globals.

for name, class in pairs(require("matrix-2")) do _G[name] = class end
