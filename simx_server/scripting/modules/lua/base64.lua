-- Bytes as base 64 text, and back.

local LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
local base64, values = {}, {}
for i = 1, #LETTERS do values[string.byte(LETTERS, i)] = i - 1 end

local function letter(value) return string.sub(LETTERS, value + 1, value + 1) end

function base64.encode(data)
    local parts = {}
    for i = 1, #data, 3 do
        local a, b, c = string.byte(data, i, i + 2)
        local number = a << 16 | (b or 0) << 8 | (c or 0)
        parts[#parts + 1] = letter(number >> 18) .. letter(number >> 12 & 63)
            .. (b and letter(number >> 6 & 63) or "=") .. (c and letter(number & 63) or "=")
    end
    return table.concat(parts)
end

function base64.decode(text)
    local parts, bits, count = {}, 0, 0
    for i = 1, #text do
        local value = values[string.byte(text, i)]
        if value then
            bits, count = (bits << 6 | value) & 0xffffff, count + 6
            if count >= 8 then
                count = count - 8
                parts[#parts + 1] = string.char(bits >> count & 255)
            end
        end
    end
    return table.concat(parts)
end

return base64
