-- The same for graphs since CoppeliaSim 4.7.

return require("graph_customization")
