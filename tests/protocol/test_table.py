"""The table and everything that is made from it agree."""

import inspect
import json
import subprocess
import sys
import types
from pathlib import Path

import pytest

import simx_client
from simx_client.legacy import local, stubs
from simx_client.legacy.functions import functions
from simx_client.protocol import constants
from simx_client.protocol.commands import BY_NAME, CARRIED, TABLE, Effect, Place

ROOT = Path(__file__).parents[2]


def test_the_table_holds_the_133_names_of_the_original_binding():
    original = [c for c in TABLE if c.place is Place.LOCAL or c.legacy_id is not None]
    assert sum(len(command.names) for command in original) == 133
    assert len({name for command in TABLE for name in command.names}) == sum(len(c.names) for c in TABLE)


def test_all_626_constants_are_there():
    names = [name for name in vars(constants) if not name.startswith("_")]
    assert len(names) == 626
    assert all(type(getattr(simx_client, name)) is int for name in names)
    assert simx_client.simx_opmode_blocking == simx_client.simx_opmode_oneshot_wait == 0x10000
    assert simx_client.sim_handle_parent == -11


def test_all_is_sorted_and_exactly_the_functions_and_constants():
    public = {name for name in dir(simx_client) if name.lower().startswith(("sim_", "simx"))}
    assert simx_client.__all__ == sorted(simx_client.__all__)
    assert set(simx_client.__all__) == set(BY_NAME) | {n for n in vars(constants) if not n.startswith("_")}
    assert public - set(simx_client.__all__) <= {"simx_client"}


@pytest.mark.parametrize(
    "use",
    [
        "vrep.simxFinish(-1)",
        "from simx_client import simxFinish",
        "assert 'simxFinish' in dir(vrep)",
        "assert 'simxFinish' in vrep.__all__",
        "exec('from simx_client import *'); assert sim_handle_parent == -11",
        "import inspect; assert dict(inspect.getmembers(vrep))['simx_return_ok'] == 0",
    ],
)
def test_the_first_use_of_one_makes_all_and_the_import_none(use):
    code = f"""
import sys, simx_client as vrep, simx_client.protocol.codec
assert "simx_client.legacy" not in sys.modules
assert "simxStart" not in vars(vrep)
{use}
assert "simxStart" in vars(vrep) and "simx_opmode_blocking" in vars(vrep)
for name in ("simxNone", "sim_none", "c_None", "none"):
    assert not hasattr(vrep, name)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", sorted(BY_NAME))
def test_every_function_is_a_real_function_with_the_parameters_of_the_original(name):
    function = getattr(simx_client, name)
    assert isinstance(function, types.FunctionType)
    command = BY_NAME[name]
    assert tuple(inspect.signature(function).parameters) == command.parameters
    assert function.__doc__
    if "clientID" in command.parameters:
        assert function.__code__.co_varnames[0] == "clientID"


def test_every_local_function_stands_in_local_and_every_entry_is_complete():
    for command in TABLE:
        assert command.doc.endswith("."), command.name
        assert set(command.key) <= {argument.name for argument in command.arguments}
        if command.place is Place.LOCAL:
            assert inspect.isfunction(getattr(local, command.name))


def test_every_value_says_what_it_means_and_every_argument_has_a_sample():
    for command in TABLE:
        for value in (*command.arguments, *command.results):
            assert value.meaning.sentence, f"{command.name}: {value.name} needs a sentence"
        for value in command.arguments:
            assert value.meaning.sample, f"{command.name}: {value.name} needs a sample"
            assert value.meaning.finder in {"", *BY_NAME}, f"{command.name}: {value.meaning.finder}"


def test_a_viewer_may_call_no_command_that_changes_something():
    for command in TABLE:
        is_read = command.effect in (Effect.READS, Effect.NOTHING)
        assert command.only_reads <= is_read
        assert command.results or not command.only_reads, f"{command.name} returns nothing and only reads"
    assert not [command.name for command in CARRIED if command.only_reads]


def test_the_client_has_no_function_without_an_entry():
    defined = {name for name in vars(local) if name.startswith("simx")}
    assert defined == {c.name for c in TABLE if c.place is Place.LOCAL}
    assert set(functions()) == set(BY_NAME)


def test_the_stub_file_is_fresh():
    assert stubs.PATH.read_text(encoding="utf-8") == stubs.render(), "run: python -m simx_client.legacy.stubs"


def test_importing_the_client_loads_neither_mujoco_nor_cv2_nor_numpy_nor_zenoh():
    code = "import sys, simx_client; print([m for m in ('mujoco','cv2','numpy','zenoh') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "[]"


def test_constants_agree_with_the_reference_beside_the_repository():
    reference = ROOT.parent / "shared" / "reference" / "legacy-constants.json"
    if not reference.exists():
        pytest.skip("the reference is not beside this repository")
    for name, value in json.loads(reference.read_text()).items():
        assert getattr(constants, name) == value
