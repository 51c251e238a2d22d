"""The notebooks run from the first cell to the last, and show what they say."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")
run_sync = pytest.importorskip("jupyter_core.utils").run_sync

pytestmark = [
    pytest.mark.slow,
    pytest.mark.system,
    pytest.mark.timeout(400),
    pytest.mark.filterwarnings("ignore"),
]

NOTEBOOKS = Path(__file__).parents[2] / "examples" / "notebooks"
NAMES = sorted(each.stem for each in NOTEBOOKS.glob("*.ipynb"))


@pytest.fixture(scope="module")
def kernels() -> Iterator[list[Any]]:
    """The manager of the kernel that all notebooks share, once there is one: it imports the simulator once."""
    managers: list[Any] = []
    yield managers
    for manager in managers:
        run_sync(manager.shutdown_kernel)(now=True)


def execute(notebook: Any, kernels: list[Any]) -> None:
    client = nbclient.NotebookClient(
        notebook,
        km=kernels[0] if kernels else None,
        timeout=300,
        kernel_name="python3",
        resources={"metadata": {"path": str(NOTEBOOKS)}},
    )
    client.execute(cleanup_kc=False)
    client.kc.stop_channels()
    kernels[:] = [client.km]


def executed(name: str, kernels: list[Any]) -> tuple[str, list[str]]:
    """Run a notebook; return its text output, and the types of all its outputs. No name is left for the next one."""
    notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    execute(notebook, kernels)
    execute(nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("%reset -f")]), kernels)
    outputs: list[Any] = [
        output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs
    ]
    text = "".join(
        each.get("text", "") or each.get("data", {}).get("text/plain", "") + "\n" for each in outputs
    )
    return text, [kind for each in outputs for kind in each.get("data", {})]


def test_four_notebooks_ship_without_outputs() -> None:
    assert NAMES == ["grade_a_class", "old_script", "train", "your_scene"]
    for name in NAMES:
        notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
        nbformat.validate(notebook)
        assert not any(cell.get("outputs") for cell in notebook.cells)


def test_an_old_script_moves_the_arm(kernels: list[Any]) -> None:
    text, _ = executed("old_script", kernels)
    assert "[0.48" in text  # 0.9 m times the cosine of 1 rad
    assert "0.75" in text


def test_an_own_scene_is_seen_in_a_cell(kernels: list[Any]) -> None:
    text, kinds = executed("your_scene", kernels)
    assert "ball: Shape" in text
    assert "the ball fell from 0.59 m to 0.05 m" in text
    assert "image/png" in kinds


def test_training_gets_better(kernels: list[Any]) -> None:
    text, _ = executed("train", kernels)
    means = [
        float(line.split("mean ")[1].split(",")[0]) for line in text.splitlines() if "generation" in line
    ]
    assert len(means) == 4
    assert means[-1] > 1.5 * means[0]


@pytest.mark.skipif(sys.platform != "linux", reason="programs are confined on Linux only")
def test_a_class_is_graded(kernels: list[Any]) -> None:
    text, _ = executed("grade_a_class", kernels)
    assert "'starter': 1.0, 'solution': 6.0" in text
