"""Kinds of trials: the later use of a file in the server, which its trial does first."""

SCENE = "scene"
"""Load it in place of the present scene."""

MODEL = "model"
"""Add it to the present scene."""

MESH = "mesh"
"""Take the points of a mesh."""

UI = "ui"
"""Show its custom UIs."""
