-- Models with settings: `ConfigUI(type, schema, generate)` keeps a model's settings in its custom data.
--
-- In CoppeliaSim a dialog changes them and calls `generate(config)`. There is no dialog here: the model stays as its file
-- has it, and a script may change the settings and generate it anew.

local ConfigUI = {}
ConfigUI.__index = ConfigUI

local function default_of(field)
    if field.default ~= nil then return field.default end
    if field.type == "bool" then return false end
    if field.type == "string" then return "" end
    if field.choices or field.type == "choices" then return (next(field.choices or {})) end
    return field.minimum or 0
end

local function new(_, model_type, schema, generate)
    local object = setmetatable({}, ConfigUI)
    object.modelType, object.schema, object.generateCb = model_type, schema or {}, generate
    object.modelHandle = sim.getObjectAssociatedWithScript(sim.handle_self)
    object.dataBlockName = { config = "__config__", schema = "__schema__", info = "__info__" }
    object.config = object:defaultConfig()
    object:readConfig()
    sim.addLog(
        sim.verbosity_scriptinfos + sim.verbosity_once,
        "the dialogs of models' settings (configUi) are not there; models stay as their files have them"
    )
    return object
end

function ConfigUI:defaultConfig()
    local config = {}
    for name, field in pairs(self.schema) do
        if type(field) == "table" then config[name] = default_of(field) end
    end
    return config
end

-- The kept settings; those that are not kept have their default.
function ConfigUI:readConfig()
    local data = sim.readCustomDataBlock(self.modelHandle, self.dataBlockName.config)
    local ok, kept = pcall(sim.unpackTable, data or "")
    for name, value in pairs(ok and type(kept) == "table" and kept or {}) do self.config[name] = value end
    return self.config
end

function ConfigUI:writeConfig()
    sim.writeCustomDataBlock(self.modelHandle, self.dataBlockName.config, sim.packTable(self.config))
end

function ConfigUI:readSchema() return self.schema end

function ConfigUI:generate()
    if self.generateCb then self.generateCb(self.config) end
end

function ConfigUI:setGenerateCallback(generate) self.generateCb = generate end

for _, name in ipairs { "createUi", "showUi", "closeUi", "updateUi", "readInfo", "writeInfo", "uiChanged" } do
    ConfigUI[name] = function() end
end

setmetatable(ConfigUI, { __call = new })
_G.ConfigUI = ConfigUI

return ConfigUI
