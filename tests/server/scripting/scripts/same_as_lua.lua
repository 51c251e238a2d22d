-- Pieces of Lua that a script and Lua without a sandbox must answer alike: tests/test_lua_errors.py.

-- traceback:
local t = debug.traceback() return t

-- traceback of a text:
local t = debug.traceback('x') return t

-- traceback of a level:
local function f(n) local t = debug.traceback('x', n) return t end local a, b, c, d, e = f(0), f(1), f(2), f(3), f(99) return a, b, c, d, e

-- traceback of what is no text:
local t = {} return debug.traceback(t) == t, debug.traceback(true), debug.traceback(nil, 1) == debug.traceback(), debug.traceback(12, 9)

-- traceback of a thread:
local co = coroutine.create(function() local b = 1
 error('boom') end) local _, m = coroutine.resume(co) return debug.traceback(co, m), debug.traceback(co), debug.traceback(co, nil), debug.traceback(co, 'x', 1), (debug.traceback(co, print) == print), debug.traceback(co, 'y', 7)

-- traceback of a waiting thread:
local co = coroutine.create(function() coroutine.yield() end) coroutine.resume(co) return debug.traceback(co, 'here')

-- traceback of this thread:
local t = debug.traceback(coroutine.running(), 'x') local u = (t:gsub('%[C%]: in function [^\n]*\n', '')) return u

-- traceback as a handler:
local function f() error('deep') end local function g() f() end local _, m = xpcall(g, debug.traceback) return m

-- traceback in a handler:
local function f() error('deep') end local function g() f() end local _, m = xpcall(g, function(e) local t = debug.traceback(e, 2) return t end) return m

-- traceback called last in a handler:
local _, m = xpcall(function() error('deep') end, function(e) return debug.traceback(e, 2) end) return m

-- traceback of a global, a field and a method:
function named() local t = {} function t.field() error('x') end function t:method() self.field() end t:method() end local _, m = xpcall(named, debug.traceback) return m

-- long traceback:
local function r(n) if n == 0 then error('bottom') end r(n - 1) return 1 end local _, m = xpcall(r, debug.traceback, 40) return m

-- error in a handler's error:
return xpcall(error, function(e) return type(e) end)

-- levels:
local function f(n) error('m', n) end local function g(n) f(n) end local _, a = pcall(g, 0) local _, b = pcall(g, 1) local _, c = pcall(g, 2) local _, d = pcall(g, 3) return a, b, c, d

-- errors that are no text:
return pcall(error), select(2, pcall(error, {5}))[1], pcall(error, 7), pcall(error, nil)

-- error within pcall:
local _, m = pcall(error, 'm', 2) return m

-- nested:
return pcall(pcall, error, 'x')

-- values:
return select('#', pcall(function() return nil, nil end)), xpcall(function(...) return ... end, print, 1, nil, 3)

-- assert:
return pcall(assert, false), pcall(assert, nil, 'm'), pcall(assert, 1, 2)

-- wrap:
local co = coroutine.wrap(function() error('inner') end) local _, m = pcall(co) return m

-- wrap calls:
local co = coroutine.wrap(function() error('inner') end) local _, m = pcall(function() local x = co() end) return m

-- wrap of a table:
local co = coroutine.wrap(function() error({3}) end) return select(2, pcall(co))[1]

-- close:
local co = coroutine.create(function() local x <close> = setmetatable({}, {__close = function() end}) coroutine.yield(1) end) coroutine.resume(co) return coroutine.close(co), coroutine.status(co)

-- dead and running:
local co co = coroutine.create(function() return coroutine.resume(co) end) return coroutine.resume(co), coroutine.resume(co), coroutine.status(co)

-- yield across pcall:
local co = coroutine.create(function(...) local a = coroutine.yield(...) return pcall(function() return coroutine.yield(a) end) end) local r, s, t = {coroutine.resume(co, 1, 2)}, {coroutine.resume(co, 'v')}, {coroutine.resume(co, 'w')} return r[1], r[2], r[3], s[2], t[2], t[3]

-- getinfo:
local i = debug.getinfo(1, 'Sl') return i.short_src, i.source, i.currentline, i.what, i.linedefined

-- getinfo of a name:
local function f() local i = debug.getinfo(1, 'nSl') return i.name, i.namewhat, i.currentline end local a, b, c = f() return a, b, c

-- getinfo of the caller:
local function f() local i = debug.getinfo(2, 'l') return i.currentline end

local a = f() return a

-- getinfo of a function:
local i = debug.getinfo(function(a, b, ...) end, 'Su') return i.nparams, i.isvararg, i.linedefined, i.what

-- getinfo of the library:
local i = debug.getinfo(print) return i.what, i.short_src, i.source, i.currentline

-- getinfo beyond:
return debug.getinfo(50)

-- fields of nothing:
return select(2, pcall(function() local x = nowhere.y end)), select(2, pcall(function() local t = {} t.x.y = 1 end)), select(2, pcall(function() return {} < {} end))

-- loaded:
return pcall(load('error("q")', '=name')), pcall(load('local x = nil + 1')), load('x ='), load('while true do', 'c'), load('return ...', 'c')(5)

-- loaded from a function:
local n = 0 return load(function() n = n + 1 return ({'return ', '1+', '2'})[n] end)(), load(function() return {} end)

-- sort and gsub:
return pcall(table.sort, {3, 2, 1}, function() error('cmp') end), pcall(string.gsub, 'abc', '%w', function(c) error('g' .. c) end)
