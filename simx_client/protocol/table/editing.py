"""Objects: removing, loading, copying, selecting."""

from __future__ import annotations

from ..kinds import FLOAT, FLOATS, INT, INTS, OPTIONAL_INTS12, TEXT
from .command import Command, Effect, Place
from .meanings import LOAD_OPTIONS, MODEL_FILE, OBJECT_HANDLE, OBJECT_HANDLES, Meaning

EDITING = (
    Command(
        name="simxRemoveObject",
        takes={"objectHandle": OBJECT_HANDLE},
        doc="Remove an object; its children move up to its parent.",
        effect=Effect.EDITS,
        key=("objectHandle",),
        legacy_id=0x1028,
        twin="sim.removeObjects",
    ),
    Command(
        name="simxRemoveModel",
        takes={"objectHandle": OBJECT_HANDLE.but(sample="base")},
        doc="Remove a model base with everything under it.",
        effect=Effect.EDITS,
        key=("objectHandle",),
        legacy_id=0x1037,
        twin="sim.removeModel",
    ),
    Command(
        name="simxLoadModel",
        takes={"modelPathAndName": MODEL_FILE, "options": LOAD_OPTIONS},
        gives={"baseHandle": Meaning(INT, "handle of the model's base")},
        doc=(
            "Add a model to the scene and return the handle of its base; option bit 0 takes the file from "
            "the client's side."
        ),
        effect=Effect.EDITS,
        key=("modelPathAndName",),
        loads_file=True,
        adds_objects=True,
        legacy_id=0x3003,
        twin="sim.loadModel",
    ),
    Command(
        name="simxCopyPasteObjects",
        takes={"objectHandles": OBJECT_HANDLES},
        gives={"newObjectHandles": Meaning(INTS, "handles of the copies")},
        doc=(
            "Copy objects, and models as a whole; returns the handles of the copies, for a model that of "
            "its base."
        ),
        effect=Effect.EDITS,
        keeps_every_call=True,
        adds_objects=True,
        legacy_id=0x102E,
        twin="sim.copyPasteObjects",
    ),
    Command(
        name="simxCreateDummy",
        takes={
            "size": Meaning(FLOAT, "m, without effect on images", sample="0.01"),
            "color": Meaning(
                OPTIONAL_INTS12,
                "0..255, four times three; the first three count",
                sample="None",
                omitted=None,
            ),
        },
        gives={"dummyHandle": Meaning(INT, "handle of the dummy")},
        doc="Add a dummy at the origin.",
        effect=Effect.EDITS,
        keeps_every_call=True,
        adds_objects=True,
        legacy_id=0x0009,
        twin="sim.createDummy",
    ),
    Command(
        name="simxGetObjectSelection",
        gives={"handles": Meaning(INTS, "handles")},
        doc="Return the selected objects.",
        effect=Effect.READS,
        legacy_id=0x0006,
        twin="sim.getObjectSel",
    ),
    Command(
        name="simxSetObjectSelection",
        takes={"objectHandles": OBJECT_HANDLES},
        doc="Replace the selection.",
        effect=Effect.CHANGES,
        legacy_id=0x102F,
        twin="sim.setObjectSel",
    ),
)

PROPERTY_NAME = Meaning(TEXT, "a property of sim.setProperty that is a number or numbers", sample="'mass'")

OF_CLIENT = (
    Command(
        name="readNumbers",
        takes={"objectHandle": OBJECT_HANDLE, "property": PROPERTY_NAME},
        gives={"values": Meaning(FLOATS, "the numbers")},
        doc="Return a property of an object as numbers.",
        effect=Effect.READS,
        place=Place.CARRIED,
        key=("objectHandle", "property"),
    ),
    Command(
        name="writeNumbers",
        takes={
            "objectHandle": OBJECT_HANDLE,
            "property": PROPERTY_NAME,
            "values": Meaning(FLOATS, "as many numbers as the property has", sample="[0.1]"),
        },
        doc="Set a property of an object to numbers; the stop of the run restores it.",
        effect=Effect.EDITS,
        place=Place.CARRIED,
        key=("objectHandle", "property"),
    ),
)
"""Calls that the client's `randomization` makes."""

OF_SERVER = (
    Command(
        name="renameObject",
        takes={
            "objectHandle": OBJECT_HANDLE,
            "objectName": Meaning(TEXT, "a name that no other object has", sample="'robot1'"),
        },
        doc="Set the name of an object, and its alias with it.",
        effect=Effect.EDITS,
        place=Place.CARRIED,
        key=("objectHandle",),
    ),
)
"""Calls that the server's gateways make, and recordings have."""
