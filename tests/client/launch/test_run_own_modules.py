"""simx-run converts modules of the script only: its own packages are none, also in a source tree."""

from __future__ import annotations

from pathlib import Path

import pytest
from launching import output_of
from processes import PENDULUM

pytestmark = [pytest.mark.slow, pytest.mark.system]


def test_an_embedded_server_is_no_module_of_a_python_2_script(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(PENDULUM)
    (tmp_path / "beside.py").write_text("print 3 / 2\n")
    script = """
        import beside, vrep
        client = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)
        import sys
        print sorted(set(type(module.__loader__).__module__ for name, module in sys.modules.items()
            if name.partition('.')[0] == 'simx_server' and module.__loader__ is not None))
    """
    said = output_of(tmp_path, script, flags=("--embed", "scene.xml"))
    assert said.splitlines() == ["1", "['_frozen_importlib_external']"]
