"""simx-run: Windows paths of a script reach real files, and only pictures it writes make folders."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from launching import output_of, simx_run

from simx_client.launch.paths import BackslashPaths

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="backslashes are separators here"),
]


@pytest.fixture
def paths(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> BackslashPaths:
    monkeypatch.chdir(tmp_path)
    return BackslashPaths(str(tmp_path / "scripts"))


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("imgTemp\\frame.jpg", "imgTemp/frame.jpg"),
        (".\\a\\b.txt", "./a/b.txt"),
        ("..\\a\\b.txt", "../a/b.txt"),
        ("a/b\\c.txt", "a/b/c.txt"),
        (Path("a\\b.txt"), "a/b.txt"),
        ("plain.txt", "plain.txt"),
        ("C:\\Users\\me\\x.jpg", "C:\\Users\\me\\x.jpg"),
        ("\\\\server\\share\\x.jpg", "\\\\server\\share\\x.jpg"),
        ("/elsewhere/strange\\name", "/elsewhere/strange\\name"),
        (b"a\\b", b"a\\b"),
        (3, 3),
        (None, None),
    ],
)
def test_which_paths_are_translated(paths: BackslashPaths, given: object, meant: object) -> None:
    assert paths.real(given) == meant


def test_paths_below_the_working_folder_and_the_scripts_are_translated(
    paths: BackslashPaths, tmp_path: Path
) -> None:
    assert paths.real(os.getcwd() + "\\a\\b.txt") == f"{tmp_path}/a/b.txt"
    assert paths.real(f"{tmp_path}/scripts\\b.txt") == f"{tmp_path}/scripts/b.txt"


def test_a_file_of_literally_that_name_wins(paths: BackslashPaths, tmp_path: Path) -> None:
    (tmp_path / "a\\b.txt").write_text("literal")
    assert paths.real("a\\b.txt") == "a\\b.txt"


def test_folders_are_made_for_writing_only(paths: BackslashPaths, tmp_path: Path) -> None:
    paths.real("read\\x.jpg")
    assert not (tmp_path / "read").exists()
    paths.real("one\\two\\x.jpg", writing=True)
    assert (tmp_path / "one" / "two").is_dir()


def test_the_tutorials_images_land_where_they_were_meant(tmp_path: Path) -> None:
    text = r"""
        import os
        import cv2
        import numpy as np
        picture = np.full((8, 8, 3), 200, np.uint8)
        path = "imgTemp\\frame.jpg"
        print(os.path.exists(path))
        cv2.imwrite("saveImg\\rgbImg\\" + "abc" + "_rgb.jpg", picture)
        cv2.imwrite(path, picture)
        print(os.path.exists(path), os.path.isfile(path), os.path.getsize(path) > 0)
        print(cv2.imread(path).shape, cv2.imread(filename=path).shape, cv2.imread("no\\such.jpg"))
        os.remove(path)
        print(os.path.exists(path), os.listdir("imgTemp"))
    """
    lines = output_of(tmp_path, text).splitlines()
    assert lines == ["False", "True True True", "(8, 8, 3) (8, 8, 3) None", "False []"]
    assert (tmp_path / "saveImg" / "rgbImg" / "abc_rgb.jpg").is_file()
    assert not [name for name in os.listdir(tmp_path) if "\\" in name]


def test_films_are_translated(tmp_path: Path) -> None:
    text = r"""
        import cv2
        import numpy as np
        film = cv2.VideoWriter("films\\a.avi", cv2.VideoWriter_fourcc(*"MJPG"), 10.0, (64, 64))
        film.write(np.zeros((64, 64, 3), np.uint8))
        film.release()
        reader = cv2.VideoCapture("films\\a.avi")
        print(isinstance(film, cv2.VideoWriter), reader.read()[0], reader.open("films\\a.avi"))
        reader.release()
    """
    assert output_of(tmp_path, text) == "True True True"
    assert (tmp_path / "films" / "a.avi").is_file()


def test_pygame_loads_and_saves(tmp_path: Path) -> None:
    pytest.importorskip("pygame")
    text = r"""
        import pygame
        surface = pygame.Surface((5, 4))
        pygame.image.save(surface, "shots\\one.png")
        print(pygame.image.load("shots\\one.png").get_size())
    """
    assert output_of(tmp_path, text).splitlines()[-1] == "(5, 4)"
    assert (tmp_path / "shots" / "one.png").is_file()


def test_numpy_files(tmp_path: Path) -> None:
    text = r"""
        import numpy as np
        np.save("data\\a", np.arange(3))
        np.savetxt("data\\b.txt", np.arange(3))
        np.arange(3.0).tofile("data\\c.bin")
        print(np.load("data\\a.npy").sum(), np.loadtxt("data\\b.txt").sum(), np.fromfile("data\\c.bin").sum())
    """
    assert output_of(tmp_path, text) == "3 3.0 3.0"


def test_pillow_files(tmp_path: Path) -> None:
    pytest.importorskip("PIL")
    text = r"""
        from PIL import Image
        Image.new("RGB", (3, 2)).save("shots\\one.png")
        print(Image.open("shots\\one.png").size)
    """
    assert output_of(tmp_path, text) == "(3, 2)"


def test_files_and_folders_of_the_standard_library(tmp_path: Path) -> None:
    text = r"""
        import glob, io, os, pathlib, shutil
        os.makedirs("log\\deep")
        os.mkdir("log\\flat")
        with open("log\\deep\\a.txt", "w") as file: file.write("hello")
        with io.open("log\\deep\\a.txt", "a") as file: file.write("!")
        print(open("log\\deep\\a.txt").read(), pathlib.Path("log\\deep\\a.txt").read_text())
        shutil.copy("log\\deep\\a.txt", "log\\b.txt")
        os.rename("log\\b.txt", "log\\c.txt")
        print(sorted(os.listdir("log")), glob.glob("log\\*.txt"))
        print(os.path.dirname("log\\c.txt"), os.path.basename("log\\c.txt"), os.path.split("log\\c.txt"))
        print(open(os.getcwd() + "\\log\\c.txt").read())
        if not os.path.isdir("log\\more"): os.makedirs("log\\more")
        shutil.rmtree("log\\deep")
        print(sorted(os.listdir("log")))
    """
    assert output_of(tmp_path, text).splitlines() == [
        "hello! hello!",
        "['c.txt', 'deep', 'flat'] ['log/c.txt']",
        "log c.txt ('log', 'c.txt')",
        "hello!",
        "['c.txt', 'flat', 'more']",
    ]


def test_a_missing_file_is_reported_without_the_launchers_frames(tmp_path: Path) -> None:
    finished = simx_run(tmp_path, 'open("none\\\\x.txt")\n')
    assert finished.returncode == 1
    assert "launch" not in finished.stderr
    assert finished.stderr.count('File "') == 1
    assert "FileNotFoundError" in finished.stderr


@pytest.mark.parametrize("flag", ["--no-path-translation", "--plain"])
def test_translation_can_be_turned_off(tmp_path: Path, flag: str) -> None:
    output_of(tmp_path, 'open("a\\\\b.txt", "w").close()\n', flags=(flag,))
    assert (tmp_path / "a\\b.txt").is_file()
