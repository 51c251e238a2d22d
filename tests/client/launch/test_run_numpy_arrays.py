"""simx-run: arrays of NumPy do what they did, and where that cannot be, one line says what to do."""

from __future__ import annotations

from pathlib import Path

import pytest
from launching import output_of, simx_run

from simx_client.launch.hints import hint
from simx_client.launch.restoring.immutable import set_attributes
from simx_client.protocol.cli.installing import line

pytestmark = pytest.mark.slow


def test_an_array_of_one_element_is_a_number_wherever_python_wants_one(tmp_path: Path) -> None:
    text = """
        import math, struct, numpy as np
        a, m = np.array([1.5]), np.matrix([[2.5]])
        row = np.zeros(2)
        row[0] = a
        print(float(a), int(a), round(a), complex(a), '%.2f %d' % (a, a), math.floor(math.exp(a)), float(m), row)
        print(struct.unpack('f', struct.pack('f', a)), float(np.array(3)), int(np.array([[7]])), float(np.float32(2)))
        print(max(0, float(np.zeros((1, 1)) + 4)), isinstance(float(a), float), type(int(a)) is int)
    """
    assert output_of(tmp_path, text).splitlines() == [
        "1.5 1 2 (1.5+0j) 1.50 1 4 2.5 [1.5 0. ]",
        "(1.5,) 3.0 7 2.0",
        "4.0 True True",
    ]


def test_an_array_of_several_is_still_no_number(tmp_path: Path) -> None:
    text = """
        import numpy as np
        for convert in (float, int, complex, round):
            for values in ([1, 2], []):
                try:
                    print(convert(np.array(values)))
                except (TypeError, ValueError):
                    print('no', end=' ')
        try:
            np.ndarray.anything = 1
        except TypeError as error:
            print(error)
    """
    assert output_of(tmp_path, text) == (
        "no no no no no no no no cannot set 'anything' attribute of immutable type 'numpy.ndarray'"
    )


def test_arrays_are_made_of_what_they_were_made_of(tmp_path: Path) -> None:
    text = """
        import numpy as np
        own = np.arange(3)
        print(np.array([1, 2], copy=False), np.array(own, copy=False) is own, np.array(own, copy=True) is own)
        print(np.array([[1, 2], [3]]).dtype, np.fromstring(b'ab', dtype=np.uint8), np.fromstring('1 2', sep=' '))
        print(len(np.linspace(0, 1, 5.0)), np.linspace(0, 1, num=3.0), np.histogram([1, 2], 2, normed=True)[0])
        try:
            np.array([[1, 2], [3]], dtype=float)
        except ValueError:
            print('not as numbers')
        image = np.zeros((2, 2), np.uint8)
        image.itemset((0, 1), 7); image.itemset(3, 9); image.itemset(1, 0, 8)
        print(image.tolist(), image.ptp(), image.ptp(axis=0), image.tostring())
        print(np.asscalar(own[:1]), np.math.pi > 3, np.linalg.linalg.LinAlgError.__name__, np.rank(image))
        print(np.asfarray([1]), issubclass(np.VisibleDeprecationWarning, Warning), np.bool8(1), np.int0(3))
    """
    assert output_of(tmp_path, text).splitlines() == [
        "[1 2] True False",
        "object [97 98] [1. 2.]",
        "5 [0.  0.5 1. ] [1. 1.]",
        "not as numbers",
        r"[[0, 7], [8, 9]] 9 [8 2] b'\x00\x07\x08\t'",
        "0 True LinAlgError 2",
        "[1.] True True 3",
    ]


def test_python_gives_back_what_its_own_arrays_and_threads_could(tmp_path: Path) -> None:
    text = """
        import array, base64, threading
        bytes_of_image = array.array('b', [-1, 2])
        bytes_of_image.fromstring(b'a')
        print(bytes_of_image.tostring(), base64.encodestring(b'x'), threading.current_thread().isAlive())
    """
    assert output_of(tmp_path, text) == r"b'\xff\x02a' b'eA==\n' True"


def test_turned_off_arrays_are_as_numpy_has_them_and_a_line_says_so(tmp_path: Path) -> None:
    text = "import numpy as np\nprint(float(np.zeros(1)))"
    finished = simx_run(tmp_path, text, flags=("--no-numpy-aliases",))
    assert finished.returncode == 1
    assert finished.stderr.splitlines()[-2:] == [
        "TypeError: only 0-dimensional arrays can be converted to Python scalars",
        "simx-run: NumPy 2.4 no longer takes an array of one element for a number: leave out --plain and "
        f"--no-numpy-aliases, write x.item(), or {line(['numpy<2.4'])}",
    ]


def test_what_cannot_be_given_back_says_what_to_install(tmp_path: Path) -> None:
    finished = simx_run(tmp_path, "import numpy as np\nprint(np.uint8(200) + 300)")
    assert finished.returncode == 1
    assert "simx-run: NumPy 2 refuses numbers that do not fit" in finished.stderr
    assert "install 'numpy<2' and" in finished.stderr


@pytest.mark.parametrize("error", [TypeError("float() argument"), OverflowError("too large"), KeyError(1)])
def test_other_exceptions_get_no_advice(error: Exception) -> None:
    assert hint(error) is None


def test_a_type_that_cannot_be_changed_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    class Changeable:
        pass

    assert set_attributes(Changeable, {"name": 1}) is True
    assert Changeable.name == 1  # type: ignore[attr-defined]
    monkeypatch.setattr("simx_client.launch.restoring.immutable.sys.implementation.name", "other")
    assert set_attributes(bytearray, {"name": 1}) is False
    assert not hasattr(bytearray, "name")
