-- A system of conveyors since CoppeliaSim 4.7.

return require("conveyor_customization-2")
