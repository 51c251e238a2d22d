"""The file of a task: errors name the line, what is wrong and what is valid."""

from __future__ import annotations

from pathlib import Path

import pytest

from simx_client.protocol.random_values import Scale, Uniform
from simx_server.grading.referee import check_names
from simx_server.grading.task.random import read_value
from simx_server.grading.task.task import TaskError, read_task

GOOD = """\
title = "Push"
scene = "cart_pole"
seeds = 2

[limits]
simulation = 5

[submission]
moves = ["cart"]
forbids = ["simxGetObjectPosition"]

[randomize]
"cart.mass" = { uniform = [0.5, 1.5] }
"pole.mass" = { scale = { uniform = [0.9, 1.1] } }

[[check]]
name = "moves"
points = 2
check = 'travelled("cart") > 0.1'

[[check]]
check = 'abs(joint("pole_joint")) < 0.5 at end'
hint = "Push."
"""


@pytest.fixture
def write(tmp_path: Path):
    def written(text: str) -> Path:
        path = tmp_path / "task.toml"
        path.write_text(text)
        return path

    return written


def test_a_task_is_what_its_file_says(write) -> None:
    task = read_task(write(GOOD))
    assert (task.title, task.seeds, task.points) == ("Push", 2, 3.0)
    assert [each.name for each in task.checks] == ["moves", 'abs(joint("pole_joint")) < 0.5 at end']
    rules = task.setting.rules
    assert (rules.seconds, rules.moves, rules.forbids) == (5.0, ("cart",), {"simxGetObjectPosition"})
    values = {name: read_value(name, described) for name, described in task.setting.random.items()}
    assert values == {"cart.mass": Uniform(0.5, 1.5), "pole.mass": Scale(Uniform(0.9, 1.1))}
    check_names(task)


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ('title = "Push"', 'titel = "Push"', 1, "did you mean 'title'"),
        ('title = "Push"', "title = 3", 1, "valid is a text"),
        ('scene = "cart_pole"', "", 1, "'scene' is missing"),
        ('scene = "cart_pole"', 'scene = "cart_poel"', 2, "cart_pole"),
        ("seeds = 2", "seeds = 0", 3, "from 1 to 100"),
        ("seeds = 2", "seeds = true", 3, "a whole number"),
        ("simulation = 5", "simulation = -1", 6, "a number from 0.1 to 3600 s"),
        ("simulation = 5", "simulatoin = 5", 6, "did you mean 'simulation'"),
        ('moves = ["cart"]', 'moves = "cart"', 9, "a list of texts"),
        ("simxGetObjectPosition", "simxGetPosition", 10, "there is no 'simxGetPosition'"),
        ('forbids = ["simxGetObjectPosition"]', 'allows = ["simxStartSimulation"]', 10, "valid:"),
        ("uniform = [0.5, 1.5]", "uniform = [1.5, 0.5]", 13, "low <= high"),
        ("uniform = [0.5, 1.5]", "unifrom = [1.5, 0.5]", 13, "log_uniform"),
        ('"cart.mass"', '"cart"', 13, "OBJECT.PROPERTY"),
        ("points = 2", "points = -2", 18, "a number from 0"),
        ("travelled(", "traveled(", 19, "did you mean 'travelled'"),
        ("at end", "at noon", 22, "not an expression"),
        ('hint = "Push."', 'hints = "Push."', 23, "did you mean 'hint'"),
        ("[limits]", "[limit]", 5, "did you mean 'limits'"),
        ("seeds = 2", 'speed = "fast"', 3, "valid is a number greater than 0, or max, not 'fast'"),
        ('hint = "Push."', "hint = ", 23, "not a TOML file"),
    ],
)
def test_an_error_names_line_and_valid_values(write, old: str, new: str, line: int, said: str) -> None:
    with pytest.raises(TaskError) as refused:
        read_task(write(GOOD.replace(old, new, 1)))
    assert said in str(refused.value)
    assert f"line {line}" in str(refused.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('travelled("cart")', 'travelled("wagon")', "line 19"),
        ('joint("pole_joint")', 'joint("cart")', "line 22"),
        ('moves = ["cart"]', 'moves = ["wagon"]', "line 9: moves: .*wagon"),
        ("seeds = 2", 'camera = "front"', "line 3: camera: .*the cameras of this scene are"),
        ('"cart.mass"', '"wagon.mass"', r"line 13: wagon\.mass: .*no object named 'wagon'"),
        ('"cart.mass"', '"cart.mas"', "line 13: .*did you mean 'mass'"),
        ("{ uniform = [0.5, 1.5] }", "[1, 2]", "line 13: .*has 1 number"),
        ("{ uniform = [0.5, 1.5] }", "-1", "line 13: .*above 0 kg"),
    ],
)
def test_what_the_scene_lacks_or_refuses_is_an_error_with_its_line(
    write, old: str, new: str, said: str
) -> None:
    task = read_task(write(GOOD.replace(old, new, 1)))
    with pytest.raises(TaskError, match=said):
        check_names(task)


def test_rules_name_functions_also_by_their_other_names(write) -> None:
    text = GOOD.replace("simxGetObjectPosition", "simxGetInt32Signal")
    rules = read_task(
        write(text.replace("forbids", 'allows = ["simxSetObjectInt32Param"]\nforbids'))
    ).setting.rules
    assert rules.forbids == {"simxGetIntegerSignal"}
    assert rules.allows == {"simxSetObjectIntParameter"}


def test_a_task_without_checks_or_file_is_refused(write, tmp_path: Path) -> None:
    with pytest.raises(TaskError, match=r"write \[\[check\]\]"):
        read_task(write('scene = "cart_pole"\n'))
    with pytest.raises(TaskError, match="cannot be read"):
        read_task(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(TaskError, match="not a TOML file"):
        read_task(tmp_path / "bytes.toml")
