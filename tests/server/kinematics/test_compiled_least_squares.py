"""Compiled inverse kinematics and those in Python give the same numbers, bit for bit, and MuJoCo's to rounding."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np
import pytest
from scenes_for_tests import world_of
from seeds import seeds

from simx_server.files.library import shipped_scenes
from simx_server.kinematics import Calculation, Constraint, Element, Group, Method, sampling
from simx_server.kinematics.chain import Arm, Ball, Joints
from simx_server.kinematics.least_squares.in_python import InPython
from simx_server.kinematics.least_squares.native import loading
from simx_server.kinematics.least_squares.problem import Problem, problem_of
from simx_server.kinematics.least_squares.steps import ADAPTIVE, DAMPED, TRANSPOSE
from simx_server.kinematics.scratch import Array
from simx_server.kinematics.search import find_configs
from simx_server.scene.poses.poses import IDENTITY, normalised

if loading.form().module is None:
    pytest.skip(f"inverse kinematics is not compiled: {loading.form().reason}", allow_module_level=True)

from simx_server.kinematics.least_squares.native import _least_squares as compiled

Random = np.random.Generator
METHODS = (DAMPED, ADAPTIVE, TRANSPOSE)


def mechanism(random: Random) -> mujoco.MjModel:
    """A tree of bodies with up to two joints each, hinges, slides and spherical ones, with values at rest."""
    spec = mujoco.MjSpec()
    bodies = [spec.worldbody]
    for number in range(int(random.integers(2, 12))):
        above = bodies[-1] if random.random() < 0.7 else bodies[int(random.integers(len(bodies)))]
        body = above.add_body(
            pos=random.uniform(-0.3, 0.3, 3),
            quat=normalised(random.normal(size=4).tolist()),
            mass=1.0,
            inertia=[1.0, 1.0, 1.0],
            explicitinertial=True,
        )
        bodies.append(body)
        kinds = random.choice(["hinge", "hinge", "slide", "ball", "two", "none"])
        for index, kind in enumerate({"two": ("slide", "hinge"), "none": ()}.get(kinds, (kinds,))):
            body.add_joint(
                name=f"j{number}_{index}",
                type=getattr(mujoco.mjtJoint, f"mjJNT_{kind.upper()}"),
                axis=random.normal(size=3),
                pos=random.uniform(-0.1, 0.1, 3),
                ref=float(random.uniform(-1, 1)) if kind != "ball" else 0.0,
            )
    return spec.compile()


def problem(model: mujoco.MjModel, data: mujoco.MjData, random: Random) -> tuple[Problem, Joints, list[Arm]]:
    """Some of a model's joints, and elements with any constraints; others stay locked."""
    ball = int(mujoco.mjtJoint.mjJNT_BALL)
    free = [joint for joint in range(model.njnt) if random.random() < 0.85]
    single = [joint for joint in free if model.jnt_type[joint] != ball]
    balls = [joint for joint in free if model.jnt_type[joint] == ball]
    owners = [*single, *(joint for joint in balls for _ in range(3))]
    dofs = [model.jnt_dofadr[joint] for joint in single]
    dofs += [model.jnt_dofadr[joint] + axis for joint in balls for axis in range(3)]
    low, high = np.full(len(owners), -math.inf), np.full(len(owners), math.inf)
    for column in range(len(single)):
        if random.random() < 0.6:
            low[column], high[column] = -random.uniform(0.1, 2), random.uniform(0.1, 2)
    joints = Joints(
        handles=tuple(single),
        addresses=np.array([model.jnt_qposadr[joint] for joint in single], dtype=np.intp),
        dofs=np.array(dofs, dtype=np.intp),
        low=low,
        high=high,
        is_hinge=np.array([model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_SLIDE for joint in owners], bool),
        max_step=random.choice([0.05, 0.2, math.inf], len(owners)),
        weights=random.choice([1.0, 1.0, 0.3, 0.0], len(owners)),
        balls=tuple(Ball(joint, int(model.jnt_qposadr[joint])) for joint in balls),
    )
    arms: list[Arm] = []
    for _ in range(int(random.integers(1, 4))):
        body, base = (int(random.integers(model.nbody)) for _ in range(2))
        element = Element(
            tip=0,
            target=0,
            constraints=Constraint(int(random.integers(32))),
            weights=(float(random.uniform(0.1, 2)), float(random.uniform(0.1, 2))),
        )
        pose = (tuple(random.uniform(-0.1, 0.1, 3).tolist()), normalised(random.normal(size=4).tolist()))
        used = random.random(len(owners)) < 0.9
        arms.append(Arm(element, body, pose, used, base, IDENTITY))  # type: ignore[arg-type]
    return problem_of(model, data, joints, arms), joints, arms


def state(model: mujoco.MjModel, random: Random) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:] = random.uniform(-1, 1, model.nq)
    mujoco.mj_normalizeQuat(model, data.qpos)
    return data


def turns_of(data: mujoco.MjData, joints: Joints) -> Array:
    turns = [normalised(data.qpos[ball.address : ball.address + 4].tolist()) for ball in joints.balls]
    return np.array(turns, dtype=float).reshape(-1, 4)


def values_of(data: mujoco.MjData, joints: Joints) -> Array:
    return np.concatenate([data.qpos[joints.addresses], np.zeros(3 * len(joints.balls))])


def in_both_forms(
    found: Problem, name: str, arrays: Sequence[Array], *rest: float
) -> tuple[object, list[Array]]:
    """Call a function of both forms with copies of arrays; return what it returns, and the arrays after that."""
    results: list[tuple[str, list[bytes]]] = []
    result: object = None
    copies: list[Array] = []
    for form in (InPython(*found), compiled.LeastSquares(*found)):
        copies = [each.copy() for each in arrays]
        result = getattr(form, name)(*copies, *rest)
        results.append(
            (repr(result), [each.tobytes() for each in copies])
        )  # repr, as nan is not equal to nan
    assert results[0] == results[1]
    return result, copies


def goals_of(found: Problem, values: Array, turns: Array) -> Array:
    return in_both_forms(found, "tips", [values, turns, np.zeros((len(found.ends), 7))])[1][2]


@pytest.mark.parametrize("seed", seeds(10))
def test_both_forms_solve_equally(seed: int) -> None:
    random = np.random.default_rng(seed)
    model = mechanism(random)
    data = state(model, random)
    found, joints, _ = problem(model, data, random)
    turns, values = turns_of(data, joints), values_of(data, joints)
    for number in range(6):
        goals = goals_of(found, random.uniform(-1.5, 1.5, len(values)), turns)
        if number == 5:
            goals[:, :3] *= 50.0  # out of reach
        in_both_forms(
            found,
            "solve",
            [values, turns, goals],
            METHODS[number % 3],
            float(random.choice([1e-6, 1e-2])),
            float(random.choice([1.0, 4.0])),
            int(random.integers(1, 40)),
            int(random.choice([1, 3, 9, 999])),
        )


@pytest.mark.parametrize("seed", seeds(7))
def test_tips_and_jacobians_are_those_of_mujoco(seed: int) -> None:
    random = np.random.default_rng(seed)
    model = mechanism(random)
    data = state(model, random)
    found, joints, arms = problem(model, data, random)
    data.qpos[joints.addresses] = random.uniform(-1, 1, len(joints.addresses))
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    turns, values = turns_of(data, joints), values_of(data, joints)
    tips = goals_of(found, values, turns)
    rows = InPython(*found).rows
    arrays = [values, turns, tips, np.zeros(rows), np.zeros((rows, len(values)))]
    error, jacobian = in_both_forms(found, "look", arrays)[1][3:]
    assert error == pytest.approx(np.zeros(rows), abs=1e-9)
    row = 0
    for arm, tip in zip(arms, tips, strict=True):
        place, turn = np.zeros(3), np.zeros(4)
        mujoco.mju_mulPose(
            place, turn, data.xpos[arm.body], data.xquat[arm.body], np.array(arm.tip[0]), np.array(arm.tip[1])
        )
        assert tip[:3] == pytest.approx(place, abs=1e-12)
        assert abs(tip[3:] @ turn) == pytest.approx(1.0, abs=1e-12)
        linear, angular, axes = np.zeros((3, model.nv)), np.zeros((3, model.nv)), np.zeros(9)
        mujoco.mj_jac(model, data, linear, angular, place, arm.body)
        mujoco.mju_quat2Mat(axes, turn)
        wanted, element = arm.element.constraints, arm.element
        parts = [
            (data.xmat[arm.base_body].reshape(3, 3).T @ linear)[i] * element.weights[0] for i in range(3)
        ]
        parts += [(axes.reshape(3, 3).T @ angular)[i] * element.weights[1] for i in range(3)]
        bits = (
            Constraint.X,
            Constraint.Y,
            Constraint.Z,
            Constraint.ALPHA_BETA,
            Constraint.ALPHA_BETA,
            Constraint.GAMMA,
        )
        for part, bit in zip(parts, bits, strict=True):
            if wanted & bit:
                assert jacobian[row] == pytest.approx(part[joints.dofs] * arm.used, abs=1e-9)
                row += 1
    assert row == rows


def test_joints_at_their_goal_stay_and_have_reached_it() -> None:
    random = np.random.default_rng(8)
    model = mechanism(random)
    data = state(model, random)
    found, joints, _ = problem(model, data, random)
    turns, values = turns_of(data, joints), np.clip(values_of(data, joints), *found.bounds[:2])
    goals = goals_of(found, values, turns)
    result, arrays = in_both_forms(found, "solve", [values, turns, goals], DAMPED, 1e-2, 1.0, 5, 99)
    assert result[2:] == (True, np.any(values == found.bounds[:2]), 1)  # type: ignore[index]
    assert arrays[0].tobytes() == values.tobytes()


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, 1e300])
def test_both_forms_end_equally_where_physics_has_diverged(number: float) -> None:
    random = np.random.default_rng(3)
    model = mechanism(random)
    data = state(model, random)
    found, joints, _ = problem(model, data, random)
    turns, values = turns_of(data, joints), values_of(data, joints)
    goals = goals_of(found, values, turns)
    for method in METHODS:
        wrong = values.copy()
        wrong[0] = number
        in_both_forms(found, "solve", [wrong, turns, goals], method, 1e-2, 1.0, 5, 99)
        for place in (0, 3):
            far = goals.copy()
            far[0, place] = number
            in_both_forms(found, "solve", [values, turns, far], method, 1e-2, 1.0, 5, 99)


@pytest.mark.parametrize("seed", seeds(5))
def test_both_forms_draw_the_same_random_starts(seed: int) -> None:
    random = np.random.default_rng(seed)
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><joint/><geom size='1'/><body pos='0 0 1'><joint axis='0 1 0'/><geom size='1'/>"
        "<body pos='0 0 1'><joint axis='1 0 0'/><geom size='1'/></body></body></body></worldbody></mujoco>"
    )
    found, _, _ = problem(model, state(model, random), random)
    low, extent = np.full(len(found.used[0]), -3.0), np.full(len(found.used[0]), 6.0)
    goals = goals_of(found, low + extent * random.random(len(low)), np.zeros((0, 4)))
    drawn: list[object] = []
    for form in (InPython(*found), compiled.LeastSquares(*found)):
        source, values = np.random.default_rng(seed), np.zeros(len(low))
        for _ in range(5):
            metric = (1.0, 0.5, 2.0, 0.1)
            result = form.sample(source, low, extent, goals, metric, 0.5, 60, values)
            drawn.append((result, values.tobytes(), source.bit_generator.state))
    assert drawn[:5] == drawn[5:]


def test_searches_and_groups_of_a_robot_find_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[list[bytes]] = []
    monkeypatch.setattr(sampling, "monotonic", lambda: 0.0)  # a slow machine does not end the search
    for form in ("python", ""):
        monkeypatch.setenv(loading.VARIABLE, form)
        world = world_of(shipped_scenes() / "ur5.xml")
        sim, groups = world.simulation, world.ik_groups
        tip, target = (sim.scene.resolve(name) for name in ("UR5_connection", "UR5"))
        group = Group("arm", [Element(tip, target)])
        joints, solver = groups.solver(group, list(sim.scene.objects))
        goals = solver.tips(np.array([0.3, 0.4, 0.9, -0.4, 0.8, 0.1]))
        configs = find_configs(solver, joints, goals, np.random.default_rng(1), seconds=0.1)
        found.append([values.tobytes() for values in configs])
        for method in (Method.PSEUDO_INVERSE, Method.DAMPED_LEAST_SQUARES, Method.JACOBIAN_TRANSPOSE):
            solution = solver.solve(np.zeros(6), goals, Calculation(method, 0.1, 30))
            found[-1].append(solution.values.tobytes())
    assert found[0] == found[1]
    assert len(found[0]) > 4


def test_arrays_that_do_not_fit_are_refused() -> None:
    random = np.random.default_rng(1)
    model = mechanism(random)
    data = state(model, random)
    found, joints, _ = problem(model, data, random)
    for number in range(len(found)):
        for wrong in (found[number][:-1], found[number][:0], found[number].astype(np.complex128)):
            if wrong.shape != found[number].shape or wrong.dtype != found[number].dtype:
                arrays = [wrong if place == number else each for place, each in enumerate(found)]
                if number == 2 and not len(found.balls) and wrong.dtype == found.balls.dtype:
                    continue
                with pytest.raises((ValueError, TypeError)):
                    compiled.LeastSquares(*arrays)  # type: ignore[arg-type]
    for place, number in ((0, len(found.links)), (0, -2), (1, 3), (1, -1), (2, 99), (2, -1)):
        links = found.links.copy()
        links[0, place] = number
        with pytest.raises(ValueError, match="do not fit"):
            compiled.LeastSquares(*found._replace(links=links))
    ends = found.ends.copy()
    ends[0, 0] = len(found.links)
    with pytest.raises(ValueError, match="do not fit"):
        compiled.LeastSquares(*found._replace(ends=ends))
    form = compiled.LeastSquares(*found)
    turns, values = turns_of(data, joints), values_of(data, joints)
    goals = np.zeros((len(found.ends), 7))
    with pytest.raises(ValueError, match="size"):
        form.tips(values[:-1], turns, goals)
    with pytest.raises(TypeError, match="type 'd'"):
        form.tips(values.astype(np.float32), turns, goals)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="read-only"):
        form.tips(values, turns, np.frombuffer(goals.tobytes()))


def test_a_variable_leaves_the_compiled_form_unused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert loading.form().reason == "compiled"
    monkeypatch.setenv(loading.VARIABLE, "python")
    assert loading.form() == (None, "SIMX_LEAST_SQUARES is python")
