"""What the server is going to do with a file, which its trial does first."""

SCENE = "scene"
"""Load it in place of the present scene."""

MODEL = "model"
"""Add it to the present scene."""

MESH = "mesh"
"""Take the points of a mesh."""

UI = "ui"
"""Show its custom UIs."""
