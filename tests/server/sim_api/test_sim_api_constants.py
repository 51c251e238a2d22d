"""Constants of V-REP: they are there, with the original's numbers."""

from __future__ import annotations

import pytest

from simx_client.protocol import constants as legacy
from simx_server.constant_tables import TABLES
from simx_server.constant_tables.counting import counted
from simx_server.sim_api.namespaces import constants


def test_names_are_counted_up_from_the_start_or_from_a_given_number() -> None:
    assert counted("x", "one two - four eight=8 nine", 1) == {
        "x_one": 1,
        "x_two": 2,
        "x_four": 4,
        "x_eight": 8,
        "x_nine": 9,
    }


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("sceneobject_shape", 0),
        ("object_collectionstart", 2_000_000),
        ("object_drawingend", 3_999_999),
        ("objecttype_scene", 127),
        ("propertytype_objectmap", 0xE2),
        ("appflavor_pro", 2),
        ("markertype_axes", 15),
        ("sceneobject_visionsensor", 9),
        ("sceneobject_customsceneobject", 19),
        ("handleflag_silenterror", 0x2000000),
        ("primitiveshape_cuboid", 3),
        ("objectproperty_ignoreviewfitting", 1),
        ("proximitysensor_ray", 34),
        ("texturemap_plane", 0),
        ("verbosity_scriptinfos", 450),
        ("verbosity_undecorated", 0xF000),
        ("colorcomponent_ambient_diffuse", 0),
        ("colorcomponent_transparency", 4),
        ("filedlg_type_save", 1),
        ("octreefloatparam_voxelsize", 13000),
        ("scriptstringparam_text", 10110),
        ("dynmat_floor", 2310021),
        ("particle_respondable1to4", 0x20),
        ("propertytype_intarray", 13),
        ("propertytype_intarray2", 15),
        ("propertytype_handlearray", 22),
        ("stringparam_machine_id", 119),
        ("stringparam_sandboxlang", 144),
        ("bullet_body_friction", 6003),
        ("vortex_joint_a2frictionloss", 21047),
        ("vortex_body_primaxisvectorz", 24036),
        ("newton_body_angulardrag", 33005),
        ("syscb_userconfig", 31),
        ("jointfloatparam_maxjerk", 2038),
    ],
)
def test_a_constant_has_the_originals_number(name: str, number: int) -> None:
    assert constants("sim")[name] == number


def test_the_tables_contradict_neither_the_legacy_constants_nor_the_functions() -> None:
    known = constants("sim")
    assert {name: known[name] for name in TABLES} == dict(TABLES)
    assert all(
        known[name.removeprefix("sim_")] == number
        for name, number in vars(legacy).items()
        if name.startswith("sim_") and isinstance(number, int)
    )
