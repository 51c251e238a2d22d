"""simx-run: programs draw as they did with matplotlib 1 to 3.6, and Pillow's and SciPy's old names are there."""

from __future__ import annotations

import inspect
import os
from importlib.util import find_spec
from pathlib import Path

import pytest
from launching import output_of, simx_run

from simx_client.launch.restoring.keywords import take_old_keywords
from simx_client.protocol.cli.installing import package_line

pytestmark = pytest.mark.slow

needs_matplotlib = pytest.mark.skipif(not find_spec("matplotlib"), reason=package_line("matplotlib"))
needs_scipy = pytest.mark.skipif(not find_spec("scipy"), reason=package_line("scipy"))
needs_pillow = pytest.mark.skipif(not find_spec("PIL"), reason=package_line("pillow"))

BEGIN = """\
import matplotlib
matplotlib.use('Agg', warn=False)
import matplotlib.pyplot as plt
from mpl_toolkits.mplot3d import Axes3D
fig = plt.figure()
"""


@pytest.fixture(autouse=True)
def settings(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """matplotlib's cache is made once, and outside the home folder."""
    folder = tmp_path_factory.getbasetemp() / "matplotlib"
    folder.mkdir(exist_ok=True)
    monkeypatch.setenv("MPLCONFIGDIR", os.fspath(folder))


@needs_matplotlib
def test_axes_in_three_dimensions_come_the_old_ways(tmp_path: Path) -> None:
    text = """
        ax = fig.gca(projection='3d')
        print(ax.name, fig.gca(projection='3d') is ax, fig.gca() is ax, plt.gca(projection='3d') is ax, len(fig.axes))
        print(plt.figure().gca(projection='3d').name, plt.figure().gca().name)
        ax.w_xaxis.set_pane_color((1, 1, 1, 1))
        other = plt.figure()
        ax = Axes3D(other)
        print(ax in other.axes, len(other.axes), len(plt.figure().add_subplot(111, projection='3d').figure.axes))
        line, = ax.plot([0], [0], [0])
        line.set_data(1, 2)
        line.set_3d_properties(3)
        plt.savefig('picture.png', frameon=False)
    """
    printed = output_of(tmp_path, BEGIN + _plain(text)).splitlines()
    assert printed == ["3d True True True 1", "3d rectilinear", "True 1 1"]
    assert (tmp_path / "picture.png").stat().st_size > 1000


@needs_matplotlib
def test_old_names_and_keywords_of_plots_work(tmp_path: Path) -> None:
    text = """
        fig.canvas.set_window_title('Robot')
        plt.hold(True)
        ax = plt.subplot(111, axisbg='k')
        ax.hold(False)
        print(ax.get_axis_bgcolor()[:3], ax.set_axis_bgcolor('r'), ax.get_facecolor()[:3])
        plt.grid(b=True)
        ax.set_color_cycle(['r', 'b'])
        print(ax.annotate(s='x', xy=(1, 1)).get_text(), sum(plt.hist([1, 2, 3], 3, normed=True)[0]))
        first, = ax.plot([1, 2], [3, 4])
        second, = ax.plot([1, 2], [3, 4])
        first.set_data(5, 6)
        print(first.get_color(), second.get_color(), first.get_xydata().tolist())
        ax.lines.remove(first)
        ax.lines.pop(0)
        ax.lines.append(first)
        print(len(ax.lines), ax.lines[0] is first)
        ax.lines = []
        del ax.patches[0]
        print(len(ax.lines), len(ax.patches), matplotlib.cm.get_cmap('jet', 4).N, plt.cm.spectral.name)
        plt.style.use('seaborn-whitegrid')
        plt.draw()
    """
    assert output_of(tmp_path, BEGIN + _plain(text)).splitlines() == [
        "(0.0, 0.0, 0.0) None (1.0, 0.0, 0.0)",
        "x 1.5",
        "b r [[5.0, 6.0]]",
        "1 True",
        "0 2 4 nipy_spectral",
    ]


@needs_matplotlib
def test_the_flag_of_numpys_aliases_turns_these_off_too(tmp_path: Path) -> None:
    text = "import matplotlib\nmatplotlib.use('Agg', warn=False)"
    finished = simx_run(tmp_path, text, flags=("--no-numpy-aliases",))
    assert finished.returncode == 1
    assert "unexpected keyword argument 'warn'" in finished.stderr


@needs_scipy
@needs_pillow
def test_an_array_of_an_image_can_be_written(tmp_path: Path) -> None:
    text = """\
        import numpy as np
        from PIL import Image
        pixels = np.asarray(Image.new("RGB", (4, 2), (1, 2, 3)))
        pixels[0, 0] = 9
        pixels.flags.writeable = True
        print(pixels[0, 0].tolist(), pixels[1, 3].tolist(), pixels.shape)
    """
    assert output_of(tmp_path, inspect.cleandoc(text)) == "[9, 9, 9] [1, 2, 3] (2, 4, 3)"


@needs_pillow
def test_the_images_of_scipy_are_back_and_its_old_names(tmp_path: Path) -> None:
    text = """
        import warnings
        warnings.simplefilter('ignore')  # SciPy says of scipy.misc itself that it will go
        import numpy as np
        from scipy.misc import imread, imresize, imsave
        picture = np.zeros((4, 6, 3), np.uint8)
        picture[:, 3:] = 200
        imsave('picture.png', picture)
        print((imread('picture.png') == picture).all(), imread('picture.png', flatten=True).shape)
        print(imresize(picture, 50).shape, imresize(picture, 2.0).shape, imresize(picture, (8, 9), 'nearest').max())
        print(imresize(np.linspace(0, 1, 16).reshape(4, 4), (4, 4)).max())
        from PIL import Image
        print(Image.open('picture.png').resize((2, 2), Image.ANTIALIAS).size, len(Image.open('picture.png').tostring()))
        from scipy.integrate import simps, cumtrapz
        from scipy.signal import gaussian
        from scipy.spatial.transform import Rotation
        print(simps([1, 1, 1]), gaussian(3, 1)[1], Rotation.from_dcm(np.eye(3)).as_dcm()[0, 0])
    """
    assert output_of(tmp_path, text).splitlines() == [
        "True (4, 6)",
        "(2, 3, 3) (8, 12, 3) 200",
        "255",
        "(2, 2) 72",
        "2.0 1.0 1.0",
    ]


def test_a_keyword_that_is_still_there_is_left_alone() -> None:
    class Library:
        @staticmethod
        def draw(color: str = "", face: str = "", **more: str) -> tuple[str, str, dict[str, str]]:
            return color, face, more

    take_old_keywords(Library, "draw", color="face", bg="face", gone=None)
    take_old_keywords(Library, "draw", bg="color")
    assert Library.draw(color="a", bg="b", gone="c", other="d") == ("a", "b", {"other": "d"})
    assert Library.draw(face="default", bg="b") == ("", "b", {})
    take_old_keywords(Library, "no_such_function", a="b")


def _plain(text: str) -> str:
    return "\n".join(line.removeprefix("        ") for line in text.splitlines()) + "\n"
