"""simx-run: names that NumPy dropped are there for the script, and nothing that is there is changed."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest
from launching import output_of, simx_run

from simx_client.launch.restoring.numpy_aliases import PYTHON_TYPES, RENAMED, give_back_aliases

pytestmark = pytest.mark.slow


def test_the_tutorials_arrays_work(tmp_path: Path) -> None:
    text = """
        import math
        import numpy as np
        jointHandle = np.zeros((6, 1), dtype=np.int)
        jointConfig = np.zeros((6, 1))
        for i in range(6):
            jointHandle[i] = i + 16
            jointConfig[i] = 0.5
        RAD2DEG = 180 / math.pi
        target = (jointConfig[2] + 1) / RAD2DEG
        jointConfig[2] = jointConfig[2] + 1
        image = np.array([-1, 5, -128]).reshape(1, 3).astype(np.uint8)
        image[0, 0] = 255 - image[0, 0]
        print(jointHandle[3].shape, target.shape, jointConfig[2], image.tolist(), np.float(3), np.bool)
    """
    finished = simx_run(tmp_path, text)
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout.startswith("(1,) (1,) [1.5] [[0, 5, 128]] 3.0")
    assert finished.stderr == ""


def test_every_old_name_is_there(tmp_path: Path) -> None:
    names = [*PYTHON_TYPES, *RENAMED, "NINF"]
    text = f"""
        import warnings
        warnings.simplefilter("ignore")
        import numpy as np
        print([name for name in {names} if not hasattr(np, name)])
        print(np.zeros(2, dtype=np.int).dtype.kind, np.array([1], np.float_).dtype, np.object, np.NINF)
    """
    assert output_of(tmp_path, text).splitlines() == ["[]", "i float64 <class 'object'> -inf"]


def test_numpy_is_patched_for_modules_that_import_it_too(tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("import numpy.linalg\nfrom numpy import int as integer\n")
    assert output_of(tmp_path, "import helper\nprint(helper.integer)") == "<class 'int'>"


def test_numpy_is_not_imported_for_scripts_that_do_not_use_it(tmp_path: Path) -> None:
    text = "import sys\nimport vrep\nprint([m for m in ('numpy', 'cv2', 'mujoco', 'pygame') if m in sys.modules])"
    assert output_of(tmp_path, text) == "[]"


@pytest.mark.parametrize("flag", ["--no-numpy-aliases", "--plain"])
def test_aliases_can_be_turned_off(tmp_path: Path, flag: str) -> None:
    text = "import numpy as np\nprint('int' in vars(np))"
    assert output_of(tmp_path, text, flags=(flag,)) == "False"


def test_a_name_that_numpy_has_is_never_replaced() -> None:
    numpy = ModuleType("numpy")
    numpy.int = numpy.prod = numpy.inf = theirs = 5  # type: ignore[attr-defined]
    give_back_aliases(numpy)
    assert numpy.int is theirs
    assert numpy.float is float
    assert numpy.product is theirs
    assert not hasattr(numpy, "row_stack"), "there is no vstack to stand for it"


def test_what_python_dropped_from_its_modules_is_back(tmp_path: Path) -> None:
    """Wrappers read parameter names with getargspec and wrap what has clientID as its first."""
    text = """
        import collections, fractions, inspect, time
        import vrep
        spec = inspect.getargspec(vrep.simxGetJointPosition)
        print(spec.args, spec[1:], time.clock() >= 0, fractions.gcd(6, 4), collections.Iterable is not None)
    """
    assert output_of(tmp_path, text) == (
        "['clientID', 'jointHandle', 'operationMode'] (None, None, None) True 2 True"
    )


def test_plain_leaves_pythons_modules_alone(tmp_path: Path) -> None:
    assert output_of(tmp_path, "import time\nprint(hasattr(time, 'clock'))", flags=("--plain",)) == "False"
