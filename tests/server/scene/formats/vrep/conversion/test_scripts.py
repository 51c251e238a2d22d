"""The scripts of a V-REP file: whose they are, how they run, and what stays out."""

from __future__ import annotations

from typing import Any

import mujoco
import pytest
from handler_calls import World

from simx_server.scene.formats.annotations import Annotations, read_annotations
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.objects import Dummy, Joint, OtherObject, Script, VrepFile
from simx_server.scene.formats.vrep.report import Report

MAIN, CHILD, JOINT, CONTACT, CUSTOMIZATION = 0, 1, 4, 5, 6


def script(**values: Any) -> Script:
    return Script(**{"id": 1, "type": CHILD, "owner": 1, "text": "x = 1", **values})


def file_with(*scripts: Script, program: tuple[int, int, int] = (3, 6, 0)) -> VrepFile:
    objects = [
        Dummy(handle=1, name="base"),
        OtherObject(handle=2, name="its_script", parent=1, kind="script"),
        Joint(handle=3, name="hinge"),
    ]
    return VrepFile(
        name="test.ttt",
        serialization=21,
        program=program,
        objects={item.handle: item for item in objects},
        scripts=list(scripts),
    )


def annotated(*scripts: Script) -> tuple[Annotations, Report]:
    spec, report = convert(file_with(*scripts))
    return read_annotations(mujoco.MjSpec.from_string(spec.to_xml())), report


def test_child_and_customization_scripts_lie_beside_their_object() -> None:
    found, report = annotated(script(text="a = 1\nb = '<&\"'"), script(type=CUSTOMIZATION, text="c = 2"))
    notes = found.objects["base"]
    assert notes["script"]["text"] == "a = 1\nb = '<&\"'"
    assert notes["customization script"]["text"] == "c = 2"
    assert list(report.needs) == ["child script of 'base'", "customization script of 'base'"]


def test_threads_disabled_scripts_and_languages_are_kept() -> None:
    found, report = annotated(
        script(is_threaded=True),
        script(type=CUSTOMIZATION, is_disabled=True, language="python", text="sim.noSuchFunction()"),
    )
    notes = found.objects["base"]
    assert notes["script"]["threaded"] is True
    assert (notes["customization script"]["language"], notes["customization script"]["enabled"]) == (
        "python",
        False,
    )
    assert list(report.needs) == ["child script of 'base'"], "a disabled script needs nothing"


@pytest.mark.parametrize(
    ("program", "is_old", "is_new"),
    [((3, 6, 0), True, False), ((4, 2, 0), False, False), ((4, 3, 0), False, True)],
)
def test_a_script_means_what_it_meant_in_the_version_of_its_file(
    program: tuple[int, int, int], is_old: bool, is_new: bool
) -> None:
    spec, _ = convert(file_with(script(), program=program))
    note = read_annotations(mujoco.MjSpec.from_string(spec.to_xml())).objects["base"].get("script", {})
    assert (note.get("joint_bases", False), note.get("full_results", False)) == (is_old, is_new)


def test_when_a_script_is_called_is_kept() -> None:
    notes = annotated(script(order=0, traversal=1), script(type=CUSTOMIZATION, traversal=2))[0].objects[
        "base"
    ]
    assert (notes["script"]["order"], notes["script"]["traversal"]) == ("first", "forward")
    assert notes["customization script"]["traversal"] == "parent"


def test_a_script_object_has_its_script() -> None:
    found, _ = annotated(script(object=2, owner=1))
    assert found.objects["its_script"]["script"]["text"] == "x = 1"
    assert "script" not in found.objects["base"]


def test_the_simulators_own_main_script_is_left_out() -> None:
    assert annotated(script(type=MAIN, owner=-1, is_default_main=True))[0].main_script is None
    own = annotated(script(type=MAIN, owner=-1, text="function sysCall_init() end"))[0].main_script
    assert own is not None
    assert own["text"] == "function sysCall_init() end"


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (script(owner=77), "scripts that belong to no object"),
        (script(type=9), "scripts of type 9"),
    ],
)
def test_what_cannot_run_is_named(given: Script, sentence: str) -> None:
    found, report = annotated(given)
    assert not any("script" in notes for notes in found.objects.values())
    assert any(each.startswith(sentence) for each in report.left_out)


def test_empty_scripts_are_no_scripts() -> None:
    found, report = annotated(script(text=" \r\n\t"))
    assert "script" not in found.objects.get("base", {})
    assert not report.left_out


def test_parameters_keep_any_text() -> None:
    values = [("speed limit", "m/s", "1, 2 = 50%"), ("name", "", ""), ("kind", "", "a\nb")]
    found, _ = annotated(script(parameters=values))
    assert found.objects["base"]["parameters"] == {"speed limit": "1, 2 = 50%", "name": "", "kind": "a\nb"}


def test_a_script_reads_its_parameters() -> None:
    pytest.importorskip("lupa")
    text = "function sysCall_init() print(sim.getScriptSimulationParameter(sim.handle_self, 'max speed')) end"
    spec, _ = convert(file_with(script(text=text, parameters=[("max speed", "m/s", "two words")])))
    world = World(spec.to_xml())
    world.call("simxStartSimulation")
    assert world.parts.status_bar.messages[-1:] == ["two words"]


def test_scripts_read_and_write_the_parameters_of_objects() -> None:
    pytest.importorskip("lupa")
    texts = {
        1: """function sysCall_init()
                print(sim.getUserParameter(sim.handle_self, 'speed'), sim.getUserParameter(0, 'speed', true))
                print(sim.setUserParameter(sim.getObject('/base'), 'speed', 2), sim.setUserParameter(0, 'new', 1))
                print(simGetScriptSimulationParameter(sim_handle_self, 'speed'), sim.getUserParameter(0, 'new'))
              end""".replace("(0", "(sim.getObject('/base')"),
        2: "function sysCall_init() print(sim.getScriptSimulationParameter(sim.handle_self, 'speed')) end",
    }
    file = file_with(script(text=texts[1]), script(text=texts[2], owner=1, object=2))
    file.objects[1].parameters = [("speed", "m/s", "0.5")]
    spec, _ = convert(file)
    world = World(spec.to_xml())
    world.call("simxStartSimulation")
    assert world.parts.status_bar.messages[-4:] == ["0.5", "0.5, 0.5", "0, 0", "2"]


def test_scripts_find_the_referenced_objects_of_the_file() -> None:
    pytest.importorskip("lupa")
    text = """function sysCall_init()
        local base = sim.getObject('/base')
        local all = sim.getReferencedHandles(base)
        print(sim.getReferencedHandle(base, 'ik.tip') == base, #all, all[2])
      end"""
    file = file_with(script(text=text))
    file.objects[1].references = {"ik.tip": [1], "": [1, 999]}
    spec, _ = convert(file)
    world = World(spec.to_xml())
    world.call("simxStartSimulation")
    assert world.parts.status_bar.messages[-1:] == ["true, 2, -1"]


def test_references_by_long_names_take_no_more_memory_than_a_scene() -> None:
    file = file_with()
    file.objects[1].name = "x" * 10_000
    file.objects[1].references = {"few": [1], "many": [1] * 10_000}
    spec, report = convert(file)
    assert len(spec.to_xml()) < 1 << 20
    assert "references whose names are too long together" in report.left_out
    assert "few=xx" in spec.to_xml()


def test_a_contact_script_decides_beside_the_others() -> None:
    text = (
        "function sysCall_contactCallback(data) return {ignoreContact = false, collisionResponse = false} end"
    )
    found, _ = annotated(script(type=CONTACT, owner=-1, text=text), script(text="y = 2"))
    assert found.objects["contactCallbackScript"]["object"]["type"] == "script"
    assert found.objects["contactCallbackScript"]["script"]["text"] == text
    assert found.main_script is None


def test_an_old_joint_script_lies_in_its_joint_unless_that_has_a_script() -> None:
    found, _ = annotated(script(type=JOINT, owner=3, text="return 1, 2"))
    assert "function sysCall_jointCallback" in str(found.objects["hinge"]["script"]["text"])
    found, report = annotated(script(owner=3), script(type=JOINT, owner=3, text="return 1, 2"))
    assert found.objects["hinge"]["script"]["text"] == "x = 1"
    assert any(each.startswith("an object has one script of a kind") for each in report.left_out)


@pytest.mark.parametrize("owner", [-1, 1, 77])
def test_an_old_call_back_without_a_joint_decides_about_contacts(owner: int) -> None:
    found, _ = annotated(script(type=JOINT, owner=owner, text="return 0"))
    text = str(found.objects["contactCallbackScript"]["script"]["text"])
    assert "function sysCall_contactCallback" in text


def test_bytes_that_no_text_can_hold_do_not_cut_a_script() -> None:
    found, _ = annotated(script(text="a = 1\0\nb = 2"))
    assert found.objects["base"]["script"]["text"] == "a = 1\nb = 2"


def test_scripts_of_old_versions_go_on_after_an_error_of_the_api() -> None:
    """V-REP 3.1.2 printed such errors, V-REP 3.4.0 stopped the script."""
    texts = script(), script(type=MAIN, owner=-1, text="a = 2"), script(type=CUSTOMIZATION)
    for program, stops in (((3, 1, 2), False), ((3, 4, 0), True)):
        spec, _ = convert(file_with(*texts, program=program))
        found = read_annotations(mujoco.MjSpec.from_string(spec.to_xml()))
        assert found.main_script is not None
        notes = found.objects["base"]
        for note in (notes["script"], notes["customization script"], found.main_script):
            assert note.get("stops_at_errors", True) is stops
