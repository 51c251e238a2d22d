"""Scripts within a scene become files: what the scene says about them stays."""

from __future__ import annotations

import mujoco

from simx_server.scene.formats.annotations import read_annotations
from simx_server.scene.formats.exporting.scripts import take_out_scripts

TEXTS = {
    "simx:lua:arm": "print(1)\r\n",
    "simx:python:customization:arm": "#python\n",
    "simx:lua:threaded:hand": "while true do end",
    "simx:lua:leg": "print('off')",
    "simx:script:leg": "threaded=yes enabled=no",
    "simx:lua:main": "function sysCall_init() end",
    "simx:lua:my,odd#0": "print('ä')",
    "simx:collection:all_of_it": "all=yes",
    "other": "simx:lua: is no annotation here",
}


def spec_with_texts() -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    for name, data in TEXTS.items():
        spec.add_text(name=name, data=data)
    return spec


def test_each_text_is_one_file_with_its_bytes_and_the_name_of_its_object() -> None:
    assert take_out_scripts(spec_with_texts()) == {
        "scripts/arm.lua": b"print(1)\r\n",
        "scripts/arm.customization.py": b"#python\n",
        "scripts/hand.threaded.lua": b"while true do end",
        "scripts/leg.lua": b"print('off')",
        "scripts/main.lua": b"function sysCall_init() end",
        "scripts/my_odd#0.lua": "print('ä')".encode(),
    }


def test_type_thread_and_options_stay() -> None:
    spec = spec_with_texts()
    take_out_scripts(spec)
    notes = read_annotations(spec)
    assert notes.objects["arm"]["script"] == {"file": "scripts/arm.lua", "type": "child"}
    assert notes.objects["arm"]["customization script"]["file"] == "scripts/arm.customization.py"
    assert notes.objects["hand"]["script"]["threaded"] is True
    leg = notes.objects["leg"]["script"]
    assert (leg["file"], leg["threaded"], leg["enabled"]) == ("scripts/leg.lua", True, False)
    assert notes.main_script is not None
    assert notes.main_script["file"] == "scripts/main.lua"
    kept = {text.name: text.data for text in spec.texts}
    assert kept["simx:collection:all_of_it"] == "all=yes"
    assert kept["other"] == TEXTS["other"]
