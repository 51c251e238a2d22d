"""One client of a server: connecting, the order of its calls, time-outs, liveness, many clients at once."""
