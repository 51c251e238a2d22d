-- Helpers that texts of CoppeliaSim require, as globals and as members of the module.

local utils = {}

function utils.asserttype(value, kind, name)
    assert(type(value) == kind, tostring(name) .. " must be a " .. kind .. ", not a " .. type(value))
end

function utils.assertnumber(value, name) utils.asserttype(value, "number", name) end

function utils.assertstring(value, name) utils.asserttype(value, "string", name) end

function utils.asserttable(value, name, size, kind)
    utils.asserttype(value, "table", name)
    assert(size == nil or #value == size, tostring(name) .. " must have " .. tostring(size) .. " elements")
    for i = 1, kind and #value or 0 do utils.asserttype(value[i], kind, tostring(name) .. "[" .. i .. "]") end
end

function utils.assertmember(value, list, name)
    for i = 1, #list do
        if list[i] == value then return end
    end
    error(tostring(name) .. " must be one of " .. getAsString(list), 2)
end

function utils.getObjectsWithTag(tag, only_models)
    local found = {}
    for _, handle in ipairs(sim.getObjectsInTree(sim.handle_scene)) do
        local fits = not only_models or sim.getModelProperty(handle) & sim.modelproperty_not_model == 0
        local data = fits and sim.readCustomDataBlock(handle, tag)
        if data and #data > 0 then found[#found + 1] = handle end
    end
    return found
end

function utils.getObjectHandle_noError(name) return sim.getObjectHandle(name .. "@silentError") end

utils.getObjectHandle_noErrorNoSuffixAdjustment = utils.getObjectHandle_noError

-- Values of an object that the server keeps until it ends.
function utils.writeSessionPersistentObjectData(object, tag, ...)
    sim.persistentDataWrite(tag .. "@" .. sim.getObjectName(object), sim.packTable({ ... }))
end

function utils.readSessionPersistentObjectData(object, tag)
    local data = sim.persistentDataRead(tag .. "@" .. sim.getObjectName(object))
    if data and #data > 0 then return table.unpack(sim.unpackTable(data)) end
end

local function attribute(name, value)
    local text = tostring(value):gsub("&", "&amp;"):gsub('"', "&quot;")
    return " " .. name .. '="' .. text .. '"'
end

-- A window around elements of a user interface; returns its handle.
function utils.createCustomUi(elements, title, position, closeable, on_close, modal, resizable, activate, more, size)
    local start = attribute("title", title) .. attribute("closeable", closeable or false)
    if closeable and on_close and on_close ~= "" then start = start .. attribute("on-close", on_close) end
    start = start .. attribute("modal", modal or false) .. attribute("resizable", resizable or false)
    start = start .. attribute("activate", activate ~= false) .. " " .. (more or "")
    if type(position) == "table" then
        start = start .. attribute("placement", "absolute") .. attribute("position", table.concat(position, ","))
    end
    if type(size) == "table" then start = start .. attribute("size", table.concat(size, ",")) end
    return simUI.create("<ui" .. start .. ">" .. elements .. "</ui>")
end

-- A list from its text, such as '1, 2, 3'; nil for another text.
function utils.stringToArray(text)
    local chunk = load("return {" .. text .. "}")
    local ok, found = pcall(chunk or error)
    return ok and found or nil
end

function utils.executeCode(text)
    local chunk = load(text)
    local ok, result = pcall(chunk or error)
    return ok and result or nil
end

-- Fills a combo box with {text, value} pairs; returns the pairs in its order, and the index of the present one.
function utils.customUi_populateCombobox(ui, id, pairs_, except, current, is_sorted, first)
    local shown, texts, index = {}, {}, 0
    for _, pair in ipairs(pairs_) do
        if not (except and except[pair[1]]) then shown[#shown + 1] = pair end
    end
    if is_sorted then table.sort(shown, function(a, b) return a[1] < b[1] end) end
    for i, pair in ipairs(first or {}) do table.insert(shown, i, pair) end
    for i, pair in ipairs(shown) do
        texts[i] = pair[1]
        if pair[1] == current then index = i - 1 end
    end
    simUI.setComboboxItems(ui, id, texts, index, true)
    return shown, index
end

function utils.canScaleObjectNonIsometrically() return true end

function utils.canScaleModelNonIsometrically() return true end

-- Scales a model along the axes of its base: each object by what becomes of its own axes.
function utils.scaleModelNonIsometrically(model, x, y, z)
    local handles, places = sim.getObjectsInTree(model), {}
    for i, handle in ipairs(handles) do
        local m = sim.getObjectMatrix(handle, model)
        local factors = {}
        for axis = 1, 3 do
            factors[axis] = math.sqrt((m[axis] * x) ^ 2 + (m[axis + 4] * y) ^ 2 + (m[axis + 8] * z) ^ 2)
        end
        places[i] = { m[4] * x, m[8] * y, m[12] * z }
        if sim.getObjectType(handle) ~= sim.object_shape_type then      -- the same factor along all axes
            local factor = (factors[1] * factors[2] * factors[3]) ^ (1 / 3)
            factors = { factor, factor, factor }
        end
        sim.scaleObject(handle, table.unpack(factors))
    end
    for i, handle in ipairs(handles) do
        if handle ~= model then sim.setObjectPosition(handle, model, places[i]) end
    end
end

for name, action in pairs(utils) do
    if _G[name] == nil then _G[name] = action end
end

return utils
