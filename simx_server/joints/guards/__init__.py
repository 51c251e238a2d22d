"""Guards of a run: physics that diverges, or whose steps would take too long, ends it."""
