"""simx-check tells of windows of OpenCV that a program opens."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path

import pytest

from simx_client.checking import command

HEAD = "import vrep\nclient = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)\n"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("import cv2\ncv2.imshow('a', image)", 4),
        ("import cv2 as cv\nwhile cv.waitKey(1) != 27:\n    pass", 4),
        ("from cv2 import cv2\ncv2.namedWindow('a')", 4),
        ("from cv2 import selectROI as pick\nbox = pick(image)", 4),
        ("from cv2 import *\nimshow('a', image)", 4),
        ("import helper", 2),
        ("import cv2\ncv2.imwrite('a.png', image)", None),
        ("import pylab\npylab.imshow(image)", None),
    ],
)
def test_windows_of_opencv_are_noted_once(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    text: str,
    line: int | None,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.py").write_text(HEAD + textwrap.dedent(text) + "\n")
    (tmp_path / "helper.py").write_text("import cv2\ncv2.waitKey(1); cv2.imshow('a', None)\n")
    command.main(["script.py", "--json"])
    found = [each for each in json.loads(capsys.readouterr().out)["findings"] if "windows" in each["text"]]
    assert [each["line"] for each in found] == ([] if line is None else [line])
    for each in found:
        assert each["level"] == "note"
        assert "simx-run" in each["text"]
