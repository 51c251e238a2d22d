"""One client of a server: connecting, the order of calls, time-outs, liveness, several clients at once."""
