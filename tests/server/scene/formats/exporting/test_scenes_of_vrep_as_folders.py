"""Files that people saved, as folders of MJCF: loading them gives the same worlds."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest
from same_worlds import assert_same_model, assert_same_world, opened
from vrep_samples import each_kind_of_sample

from simx_server.scene.formats.exporting.folder import write_folder
from simx_server.scene.formats.sources import Sources

pytestmark = pytest.mark.slow


@each_kind_of_sample
def test_folder_of_a_sample_gives_the_same_world(
    path: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        target = write_folder(path, tmp_path / "out", Sources.of())
    assert "differs" not in caplog.text
    if path.suffix == ".ttt":
        with opened(path, target) as (first, second):
            assert_same_world(first, second, 5)
    else:
        with opened(path, target.with_name(f"{target.stem}_scene.xml")) as (first, second):
            assert_same_model(first, second)
