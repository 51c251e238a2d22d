-- Bytes of CoppeliaSim's API 2, which differ from text: tostring(buffer) is the string with these bytes.

local Buffer = {}
Buffer.__index = Buffer

setmetatable(Buffer, { __call = function(_, text)
    if getmetatable(text) == Buffer then return text end
    assert(type(text) == "string", "a buffer is made of a string")
    return setmetatable({ _text = text }, Buffer)
end })

function Buffer:__tostring() return self._text end
function Buffer:__len() return #self._text end
function Buffer.__eq(a, b) return a._text == b._text end
function Buffer.__concat(a, b) return Buffer(tostring(a) .. tostring(b)) end
function Buffer:sub(first, last) return Buffer(self._text:sub(first, last)) end
function Buffer:byte(...) return self._text:byte(...) end

return Buffer
