"""Functions for what V-REP showed in its window: views, old custom UIs, and those made from XML."""
