"""A script that waits for an image: the renderer's time, and that of others, is not the script's."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from handler_calls import PaintingThread, World

SCENE = """
<mujoco>
  <worldbody><body name="base"><geom size="0.1"/><camera name="eye" resolution="4 4"/></body></worldbody>
  <custom><text name="simx:script:base" data="file={file}"/></custom>
</mujoco>
"""
LIMIT = 0.3
WAITS = {
    "waits.lua": """
        function sysCall_actuation()
            for i = 1, 3 do sim.getVisionSensorImage(sim.getObjectHandle('eye')) end
            for i = 1, 1e4 do local x = i * i end
            print('seen')
        end
    """,
    "waits.py": """
def sysCall_actuation():
    for i in range(3):
        sim.getVisionSensorImg(sim.getObject('/eye'))
    sum(range(10**4))
    print('seen')
""",
    "property.lua": """
        function sysCall_actuation()
            sim.getBufferProperty(sim.getObject('/eye'), 'imageBuffer')
            for i = 1, 1e4 do local x = i * i end
            print('seen')
        end
    """,
}


def busy_for(seconds: float) -> None:
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


@pytest.mark.parametrize("name", WAITS)
def test_the_time_of_a_wait_for_images_does_not_count(tmp_path: Path, name: str) -> None:
    pytest.importorskip("lupa")
    (tmp_path / name).write_text(WAITS[name], encoding="utf-8")
    (tmp_path / "scene.xml").write_text(SCENE.format(file=name), encoding="utf-8")
    painter = PaintingThread()
    world = World(file=tmp_path / "scene.xml", painter=painter)
    world.parts.scripts.time_limit = LIMIT

    def serve_others() -> None:
        if painter.is_asked:  # a client keeps the server busy until the picture is there
            busy_for(0.6 * LIMIT)  # three times: more than the limit
            painter.paint()

    world.sim.interruptions.serve_others = serve_others
    world.run(1)
    assert world.parts.status_bar.messages[-1].endswith("seen")
    world.call("simxStopSimulation")
