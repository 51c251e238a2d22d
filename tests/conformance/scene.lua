-- The functions that the conformance suite calls; a table for the dotted name.
function echo(ints, floats, strings, buffer)
    return ints, floats, strings, buffer
end

function fails(ints, floats, strings, buffer)
    error('on purpose')
end

function too_few(ints, floats, strings, buffer)
    return {}, {}
end

nested = {}
function nested.echo(ints, floats, strings, buffer)
    return ints, floats, strings, buffer
end

function set_signal(ints, floats, strings, buffer)
    sim.setIntegerSignal(strings[1], ints[1])
    return {}, {}, {}, ''
end
