"""Stand-ins for plug-ins of V-REP that connect other programs: they accept calls, connect nothing, and say so once."""
