-- Bytes as hexadecimal text, and back.

local base16 = {}

function base16.encode(data)
    return (string.gsub(data, ".", function(letter) return string.format("%02x", string.byte(letter)) end))
end

function base16.decode(text)
    if #text % 2 == 1 or string.find(text, "%X") then error("base16.decode: not a hexadecimal text", 2) end
    return (string.gsub(text, "%x%x", function(pair) return string.char(tonumber(pair, 16)) end))
end

return base16
