-- An older name.

return require("conveyor_customization-2")
