-- Colours of CoppeliaSim's API 2: red, green, blue and alpha, 0 to 255, and as parts from 0 to 1.

local Color = {}

local NAMES = {
    black = 0x000000, white = 0xffffff, red = 0xff0000, green = 0x00ff00, blue = 0x0000ff, yellow = 0xffff00,
    cyan = 0x00ffff, magenta = 0xff00ff, gray = 0x808080, grey = 0x808080, orange = 0xffa500,
}

local function byte(value) return math.tointeger(math.min(255, math.max(0, math.floor(value + 0.5)))) end

local function of(r, g, b, a) return setmetatable({ byte(r), byte(g), byte(b), byte(a or 255) }, Color) end

local function of_number(number, alpha) return of(number >> 16 & 255, number >> 8 & 255, number & 255, alpha) end

local PLACES = { r = 1, red = 1, g = 2, green = 2, b = 3, blue = 3, a = 4, alpha = 4 }

function Color:__index(key)
    if PLACES[key] then return rawget(self, PLACES[key]) / 255 end
    return Color[key]
end

function Color.ofbytes(bytes) return of(bytes[1], bytes[2], bytes[3], bytes[4]) end
function Color.__eq(a, b) return a[1] == b[1] and a[2] == b[2] and a[3] == b[3] and a[4] == b[4] end
function Color:__tostring() return string.format("Color(#%02x%02x%02x%02x)", self[1], self[2], self[3], self[4]) end
function Color:bytes() return { self[1], self[2], self[3], self[4] } end
function Color:data() return { self[1] / 255, self[2] / 255, self[3] / 255 } end
function Color:html() return string.format("#%02x%02x%02x", self[1], self[2], self[3]) end

-- Of a name, of "#rrggbb" or "#rrggbbaa", of parts from 0 to 1, or of a table of parts or bytes.
setmetatable(Color, { __call = function(_, value, g, b, a)
    if getmetatable(value) == Color then return of(value[1], value[2], value[3], value[4]) end
    if type(value) == "string" then
        local hex, alpha = value:match("^#(%x%x%x%x%x%x)(%x?%x?)$")
        if hex then return of_number(tonumber(hex, 16), alpha ~= "" and tonumber(alpha, 16) or 255) end
        local number = assert(NAMES[value], "no colour is called '" .. value .. "'")
        return of_number(number)
    end
    local parts = type(value) == "number" and { value, g, b, a } or value
    assert(type(parts) == "table" and #parts >= 3, "a colour has red, green and blue")
    local are_bytes = parts[1] > 1 or parts[2] > 1 or parts[3] > 1
    local scale = are_bytes and 1 or 255
    return of(parts[1] * scale, parts[2] * scale, parts[3] * scale, parts[4] and parts[4] * scale)
end })

return Color
