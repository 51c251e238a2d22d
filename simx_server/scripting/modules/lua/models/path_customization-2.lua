-- The same for paths since CoppeliaSim 4.7.

return require("path_customization")
