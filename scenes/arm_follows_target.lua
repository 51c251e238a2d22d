-- Lets an arm follow a target dummy, once a client moves it.
--
-- V-REP's stock arms have no inverse kinematics; public scripts either set target positions of the joints, or they move
-- a dummy in scenes whose authors added it. Here both work: joints obey their target positions until somebody moves
-- the target away from where it was; from then on, until the simulation stops, they do what the scene's inverse
-- kinematics group asks them for.
--
-- The script belongs to the arm's base NAME; the scene registers the group NAME_ik with the target NAME_target, or
-- NAME_ikTip_ik with NAME_ikTarget, or both (then the arm follows the one that was moved last). handling=explicit.

local PAIRS = {{target = '_target', group = '_ik'}, {target = '_ikTarget', group = '_ikTip_ik'}}
local NOT_MOVED = 1e-6      -- m, and of quaternion components
local HYBRID = 1            -- joints in IK mode whose values are carried out by their motors

local base
local joints = {}
local pairs_found = {}
local followed              -- the pair whose target was moved last

local function place_of(target)
    local place = sim.getObjectPosition(target, base)
    for _, part in ipairs(sim.getObjectQuaternion(target, base)) do
        place[#place + 1] = part
    end
    return place
end

local function has_moved(pair)
    local place = place_of(pair.target)
    for index, value in ipairs(place) do
        if math.abs(value - pair.place[index]) > NOT_MOVED then
            pair.place = place
            return true
        end
    end
    return false
end

function sysCall_init()
    base = sim.getObjectAssociatedWithScript(sim.handle_self)
    local name = sim.getObjectName(base)
    local number = 1
    local joint = sim.getObjectHandle(name .. '_joint1@silentError')
    while joint ~= -1 do
        joints[number] = joint
        number = number + 1
        joint = sim.getObjectHandle(name .. '_joint' .. number .. '@silentError')
    end
    for _, pair in ipairs(PAIRS) do
        local target = sim.getObjectHandle(name .. pair.target .. '@silentError')
        if target ~= -1 then
            local group = sim.getIkGroupHandle(name .. pair.group)
            pairs_found[#pairs_found + 1] = {target = target, group = group, place = place_of(target)}
        end
    end
end

function sysCall_actuation()
    for _, pair in ipairs(pairs_found) do
        if has_moved(pair) then
            if followed == nil then
                for _, joint in ipairs(joints) do
                    sim.setJointMode(joint, sim.jointmode_ik, HYBRID)
                end
            end
            followed = pair
        end
    end
    if followed ~= nil then
        sim.handleIkGroup(followed.group)
    end
end
