"""Scripts that judge the pictures of their vision sensors, and what clients see of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from handler_calls import PaintingThread, QuickPainter, World
from real_world import RealWorld, handle_of, render_with, start_stepped, step
from scripted_world import said, scripted

import simx_client as vrep

pytestmark = [pytest.mark.slow, pytest.mark.gl]

pytest.importorskip("lupa")

BLOCKING = vrep.simx_opmode_blocking

LINE_SENSOR = """
function sysCall_vision(inData)
    simVision.sensorImgToWorkImg(inData.handle)
    simVision.edgeDetectionOnWorkImg(inData.handle, 0.2)
    local answer = {trigger = false, packedPackets = {}}
    simVision.sensorImgToWorkImg(inData.handle)
    simVision.intensityScaleOnWorkImg(inData.handle, 1, 0, true)
    local trigger, packet = simVision.binaryWorkImg(inData.handle, 0.5, 1, 0.9, 0.5, 1, 0.5, 1, 0, 4, 1, true)
    if trigger then answer.trigger = true end
    if packet then answer.packedPackets[#answer.packedPackets + 1] = packet end
    simVision.workImgToSensorImg(inData.handle)
    return answer
end
"""
"""As on a line tracer: black on white is found, and shown as white on black."""

TRACK = """
<mujoco><option gravity="0 0 0" timestep="0.01"/>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <worldbody>
    <geom name="ground" type="plane" size="2 2 0.1" rgba="1 1 1 1"/>
    <geom name="line" type="box" size="0.02 1 0.001" rgba="0 0 0 1"/>
    <body name="carrier" pos="-0.2 0 0.1">
      <joint name="slide" type="slide" axis="1 0 0"/><geom size="0.01" mass="1" contype="0" conaffinity="0"/>
      <camera name="left" resolution="16 16" fovy="40"/>
      <camera name="lazy" resolution="16 16" fovy="40"/>
    </body>
  </worldbody>
  <custom>
    <text name="simx:vision:left" data="near=0.02 far=0.5"/>
    <text name="simx:vision:lazy" data="near=0.02 far=0.5"/>
    <text name="simx:joint:slide" data="mode=passive"/>
    <text name="simx:script:left" data="file=left.lua"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def track(tmp_path: Path) -> Iterator[RealWorld]:
    (tmp_path / "left.lua").write_text(LINE_SENSOR)
    (tmp_path / "track.xml").write_text(TRACK)
    world = RealWorld(tmp_path / "track.xml")
    yield world
    world.close()


def test_a_script_decides_what_a_line_sensor_detects(track: RealWorld) -> None:
    client = track.client()
    left, slide = handle_of(client, "left"), handle_of(client, "slide")
    start_stepped(client)
    step(client, 0.1)
    code, detects, packets = vrep.simxReadVisionSensor(client, left, BLOCKING)
    assert (code, detects, len(packets)) == (0, False, 2)
    assert packets[0][10] > 0.9  # the picture itself is white
    assert packets[1][0] == 0.0
    vrep.simxSetJointPosition(client, slide, 0.2, BLOCKING)
    step(client, 0.05)
    code, detects, packets = vrep.simxReadVisionSensor(client, left, BLOCKING)
    assert (code, detects, len(packets)) == (0, True, 2)
    assert packets[0][10] < 0.9
    share, x, y, angle, roundness = packets[1]
    assert 0.2 < share < 0.9
    assert (x, y) == pytest.approx((0.5, 0.5), abs=0.04)
    assert abs(angle) == pytest.approx(np.pi / 2)
    assert roundness < 0.6


def test_clients_get_the_image_that_a_script_has_made(track: RealWorld) -> None:
    client = track.client()
    left, lazy = handle_of(client, "left"), handle_of(client, "lazy")
    start_stepped(client)
    step(client, 0.05)
    _, size, image = vrep.simxGetVisionSensorImage(client, left, 1, BLOCKING)
    assert (size, set(image)) == ([16, 16], {0})
    _, _, plain = vrep.simxGetVisionSensorImage(client, lazy, 1, BLOCKING)
    assert plain[0] not in (0, image[0])
    vrep.simxStopSimulation(client, BLOCKING)
    while vrep.simxGetVisionSensorImage(client, left, 1, BLOCKING)[2] != plain:
        step(client, 0.05)


EYES = """
<body name="head" pos="0 0 1"><geom size="0.05"/>
  <camera name="eye" resolution="8 4"/><camera name="other" resolution="8 4"/>
  <camera name="asked" resolution="8 4"/>
</body>
<body name="wall" pos="0.5 0 1"><geom name="wall" type="box" size="0.1 1 1"/></body>
<site name="beam" pos="0 0 1"/>
"""
EYE_NOTES = '<text name="simx:vision:asked" data="explicit=yes"/>'


def eyes(painter: PaintingThread | None = None, **scripts: str) -> World:
    """Scripts by the names of their sensors."""
    world = scripted({f"lua:{name}": text for name, text in scripts.items()}, body=EYES, custom=EYE_NOTES)
    world.painter = painter or QuickPainter()
    render_with(world, world.painter)
    return world


def test_only_a_sensor_with_such_a_script_is_rendered_in_each_step() -> None:
    world = eyes(eye="function sysCall_vision(inData) end", other="function sysCall_sensing() end")
    world.run(3)
    assert [view.camera_id for view in world.painter.views] == [0, 0, 0]


def test_the_call_back_is_told_about_its_sensor() -> None:
    world = eyes(
        eye="""
        function sysCall_vision(inData)
            print(inData.handle == sim.getObjectHandle('eye'), inData.resolution[1], inData.resolution[2],
                  inData.clippingPlanes[1] < inData.clippingPlanes[2], inData.viewAngle > 0,
                  inData.perspectiveOperation)
        end
        function sysCall_sensing() print('sensing') end"""
    )
    world.run(1)
    assert said(world) == ["true, 8, 4, true, true, true", "sensing"]


def test_packets_follow_the_statistics_until_the_next_pass_and_end_with_the_run() -> None:
    world = eyes(
        eye="""
        n = 0
        function sysCall_vision(inData)
            n = n + 1
            return {trigger = n == 2, packedPackets = {sim.packFloatTable({n, 7}), sim.packFloatTable({})}}
        end
        function sysCall_sensing() print(sim.readVisionSensor(sim.handle_self)) end"""
    )
    world.run(1)
    for n in (1, 2, 3):
        detects, packets = world.call("simxReadVisionSensor", world.handle("eye"))
        assert (detects, [len(packet) for packet in packets], packets[1]) == (n == 2, [15, 2, 0], [n, 7])
        assert said(world)[-1].startswith("1, " if n == 2 else "0, ")
        world.parts.step()
    world.sim.stop()
    with pytest.raises(Exception, match="has not been handled yet"):
        world.call("simxReadVisionSensor", world.handle("eye"))


def test_a_sensor_handled_explicitly_is_judged_when_it_is_handled() -> None:
    world = eyes(
        asked="""
        function sysCall_vision(inData) print('judged') return {trigger = true} end
        function sysCall_actuation()
            if sim.getSimulationTime() > 0 then print(sim.handleVisionSensor(sim.handle_self)) end
        end"""
    )
    world.run(1)
    assert said(world) == []
    world.parts.step()
    assert [line[:6] for line in said(world)] == ["judged", "1, {0."]


def test_an_image_that_is_set_is_judged_too() -> None:
    world = eyes(
        asked="""
        function sysCall_vision(inData)
            simVision.sensorImgToWorkImg(inData.handle)
            simVision.horizontalFlipWorkImg(inData.handle)
            simVision.workImgToSensorImg(inData.handle)
            sim.setVisionSensorCharImage(sim.handle_self, string.rep('\\9', 96))
        end"""
    )
    world.run(1)
    grey = bytes(range(32))
    world.call("simxSetVisionSensorImage", world.handle("asked"), grey, 1)
    assert world.call("simxGetVisionSensorImage", world.handle("asked"), 1) == ([8, 4], b"\t" * 32)


def test_a_main_script_that_handles_all_keeps_what_was_judged() -> None:
    world = eyes(
        eye="function sysCall_vision(inData) return {trigger = true} end",
        main="function sysCall_sensing() sim.handleVisionSensor(sim.handle_all_except_explicit) end",
    )
    world.run(2)
    assert world.call("simxReadVisionSensor", world.handle("eye"))[0] is True
    assert len(world.painter.views) == 2


def test_a_detection_triggers_and_the_script_may_take_it_back() -> None:
    world = eyes(
        eye="""
        function sysCall_vision(inData) return {trigger = true, packedPackets = {sim.packFloatTable({5})}} end
        function sysCall_trigger(inData)
            local first = sim.unpackFloatTable(inData.packedPackets[1])
            print(#inData.packedPackets, #first, sim.unpackFloatTable(inData.packedPackets[2])[1])
            return {trigger = false}
        end""",
        other="function sysCall_trigger(inData) print('never') end",
    )
    world.run(1)
    assert said(world) == ["2, 15, 5.0"]
    detects, packets = world.call("simxReadVisionSensor", world.handle("eye"))
    assert (detects, packets[1]) == (False, [5])


def test_a_proximity_sensor_tells_its_script_what_it_detects(tmp_path: Path) -> None:
    scene = """<mujoco><option gravity="0 0 0"/><worldbody>
      <site name="beam" pos="0 0 1" euler="0 90 0"/>
      <body name="wall" pos="0.5 0 1"><geom type="box" size="0.1 1 1"/></body></worldbody>
      <sensor><rangefinder name="beam" site="beam" cutoff="2"/></sensor><custom><text name="simx:lua:beam" data="
      function sysCall_trigger(d)
        print(sim.getObjectName(d.detectedObjectHandle), d.detectedPoint[3], d.normalVector[3])
      end"/></custom></mujoco>"""
    world = World(scene)
    world.run(1)
    name, distance, normal = said(world)[0].split(", ")
    assert (name, float(distance), float(normal)) == ("wall", pytest.approx(0.4), pytest.approx(-1))


def test_an_error_in_the_call_back_stops_the_script_and_leaves_the_image() -> None:
    world = eyes(eye="function sysCall_vision(inData) simVision.workImgToSensorImg(inData.handle) end")
    world.run(2)
    assert "the sensor has no work image yet" in said(world)[-1]
    assert len(world.call("simxGetVisionSensorImage", world.handle("eye"), 0)[1]) == 96


def test_a_python_script_judges_images_too() -> None:
    world = scripted(
        {
            "python:eye": """
def sysCall_vision(inData):
    simVision.sensorImgToWorkImg(inData['handle'])
    simVision.uniformImgToWorkImg(inData['handle'], [1, 1, 1])
    simVision.workImgToSensorImg(inData['handle'])
    return {'trigger': True, 'packedPackets': [sim.packFloatTable([1.5])]}
"""
        },
        body=EYES,
        custom=EYE_NOTES,
    )
    render_with(world, QuickPainter())
    world.run(1)
    detects, packets = world.call("simxReadVisionSensor", world.handle("eye"))
    assert (detects, packets[1]) == (True, [1.5])
    assert set(world.call("simxGetVisionSensorImage", world.handle("eye"), 0)[1]) == {255}
    world.sim.stop()


def test_scripts_of_later_versions_require_the_namespace() -> None:
    world = eyes(
        eye="local vision = require('simVision') function sysCall_init() print(vision == simVision) end"
    )
    world.run(0)
    assert said(world) == ["true"]


def test_script_reads_its_sensor_in_the_sensing_of_the_first_step(tmp_path: Path) -> None:
    source = "function sysCall_sensing() print(sim.readVisionSensor(sim.getObject('/eye'))) end"
    world = scripted({"lua:base": source}, '<body name="base"><geom size="1"/><camera name="eye"/></body>')
    render_with(world, QuickPainter())
    world.run()
    assert said(world)[0].startswith("0")


def test_python_script_names_two_packets_of_a_plain_sensor() -> None:
    source = (
        "def sysCall_sensing():\n    result, first, second = sim.readVisionSensor(sim.getObject('/eye'))\n"
        "    print(result, len(first), second)\n"
    )
    world = scripted({"python:base": source}, '<body name="base"><geom size="1"/><camera name="eye"/></body>')
    render_with(world, QuickPainter())
    world.run()
    lines = said(world)
    world.parts.scripts.close()
    assert lines == ["0 15 None"]
