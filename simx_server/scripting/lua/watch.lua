-- The hook that checks the clock while a script runs: it stops endless scripts and lets the server answer
-- other clients.
--
-- After the time limit it runs on every instruction, otherwise `while true do pcall(busy) end` would catch it
-- for ever. The interval between two runs becomes shorter when the last instructions took long and when the
-- heap is large, because one instruction may copy a string as long as the heap is large. Each coroutine has a
-- separate hook, so coroutines are created here. In a coroutine that its hook has ended, no hook runs any
-- more, so its pending `<close>` variables are never closed.

local late = ...

local sethook, getinfo, cocreate, coclose, current =
    debug.sethook, debug.getinfo, coroutine.create, coroutine.close, coroutine.running
local clock, heap, error, setmetatable, min = os.clock, collectgarbage, error, setmetatable, math.min
local struck, watch, spared = false, nil, {}
local suspects = false                                          -- whether the heap may have grown much

-- "file:line: " of the innermost frame that is the script's own
local function where()
    for frame_level = 2, 30 do
        local frame = getinfo(frame_level, "Sl")
        if not frame then break end
        if frame.source ~= "=sandbox" and frame.currentline > 0 then
            return frame.short_src .. ":" .. frame.currentline .. ": "
        end
    end
    return ""
end

-- Instructions between two runs of the hook: as many as take about 1 ms; 500 cheap ones take 0.005 ms. After a
-- large piece of work, and when the heap has grown, the minimum, from which it grows slowly: what is compared or
-- joined next may be large too. The clock is read from the first run of the hook on: reading it takes as long as
-- a short call into a script. WORK: instructions times kilobytes of the heap; with UNSEEN of it the hook runs without
-- reading the clock, while the time for that was short.
local FIRST, LEAST, SMALL, LARGE, MOST, WORK, UNSEEN = 100, 2, 32, 100000, 2000, 1000000, 4000000
local interval, greatest, last_strike, last_look = FIRST, FIRST, nil, nil
local unread, most_unread = 0, 0                                -- runs of the hook before the next look at the clock

-- Checks Python's clock and serves other clients, at most once per millisecond. True: the time is over.
local function must_stop()
    local now = clock()
    last_look = last_look or now
    if now - last_look < 0.001 then return struck end
    struck = late() or struck
    local kilobytes = heap("count")
    greatest = kilobytes < 2000 and min(MOST, WORK // kilobytes) or kilobytes < 8000 and 400 or kilobytes < 16000 and 150 or 20
    most_unread = kilobytes < 2000 and UNSEEN // (greatest * kilobytes) or 0
    last_look = clock()
    return struck
end

-- The interval of each coroutine's hook. It is set only on a change, because setting it restarts its count.
local spans = setmetatable({}, { __mode = "k" })

local function set(span)
    spans[current()] = span
    sethook(watch, "", span)
end

-- Prepares for costly instructions. A hook with the least interval is not set again, or it would never run.
local function beware()
    if struck then return end
    if interval > LEAST then interval = LEAST end
    unread = 0
    local span = spans[current()]
    if span and span > LEAST then set(LEAST) end
end

local ended = setmetatable({}, { __mode = "k" })

local function stop()
    ended[current()] = true
    sethook(watch, "", 1)
    error(where() .. "took too long and was stopped (an endless loop?)", 0)
end

local function is_large()
    suspects = false
    return heap("count") > 1000
end

function watch()
    if unread > 0 and not struck then
        unread = unread - 1
        return
    end
    if not struck then
        local now = clock()
        local is_first = not last_strike
        local took = is_first and 0 or now - last_strike
        last_look = last_look or now
        local wanted = is_first and interval or took > 0.01 and LEAST or took > 0.002 and interval // 8
            or took < 0.0005 and (interval < SMALL and interval + LEAST or interval * 2) or interval
        if suspects and is_large() then wanted = LEAST end
        if wanted > greatest then wanted = greatest elseif wanted < LEAST then wanted = LEAST end
        unread = wanted == greatest and interval == greatest and took < 0.0005 and most_unread or 0
        interval = wanted
        if spans[current()] ~= wanted then
            set(wanted)
        end
        last_strike = now
        if now - last_look < 0.001 then return end
    end
    if must_stop() then
        local running = getinfo(2, "f")
        if running and spared[running.func] then return end
        stop()
    end
    last_strike = clock()
end

-- For the library, around calls that take long without many instructions.
local function look(size)
    if size and size > LARGE then beware() end
    if must_stop() then stop() end
end

-- Instructions such as `a .. b` take memory too. The collector, which runs after a certain amount of it, calls
-- this. Here the size of the heap is not known yet; the hook, which runs soon, looks at it.
local armed = false
local sentinel = {}
function sentinel.__gc()
    setmetatable({}, sentinel)
    local span = spans[current()]
    if not armed or struck or not span or span <= LEAST then return end
    suspects, unread = true, 0
    set(LEAST)
end
setmetatable({}, sentinel)

local function create(body)
    local thread = cocreate(body)
    spans[thread] = interval
    sethook(thread, watch, "", interval)
    return thread
end

local function quicken(thread)
    if spans[thread] and spans[thread] > interval then
        spans[thread] = interval
        sethook(thread, watch, "", interval)
    end
end

local function close(thread)
    if ended[thread] then return false, "took too long and was stopped" end
    return coclose(thread)
end

local main = current()

-- Begins a call from outside any coroutine.
local function begin()
    interval, unread, last_strike, last_look, armed = FIRST, 0, nil, nil, true
    spans[main] = FIRST
    sethook(watch, "", FIRST)
end

local function arm() set(struck and 1 or interval) end

local function disarm()
    sethook()
    struck, armed = false, false
end

-- Functions in which the hook does not run: the way into a script, and the way out.
local function spare(...)
    for _, action in ipairs { ... } do spared[action] = true end
end

return {
    where = where, look = look, create = create, quicken = quicken, close = close, begin = begin, arm = arm,
    disarm = disarm, spare = spare,
}
