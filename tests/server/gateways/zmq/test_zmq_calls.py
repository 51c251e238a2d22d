"""Results of the official client: objects made of the namespaces, values, errors."""

from __future__ import annotations

from typing import Any

import pytest
from zmq_world import ZmqWorld

from simx_server.gateways.zmq import gateway
from simx_server.scene.editing import recompile


def test_a_client_gets_functions_constants_and_nested_tables(server: ZmqWorld) -> None:
    client = server.client()
    sim, ompl = client.require("sim"), client.require("simOMPL")
    assert sim.handle_all == -2
    assert ompl.Algorithm.RRTConnect >= 0
    box = sim.getObject("/box")
    assert sim.getObjectPosition(box, -1) == pytest.approx([1, 0, 0.5])
    assert client.getObject("sim").getObject("/box") == box, "getObject alone is enough"
    assert client.require("sim-2").getObject("/box") == box, "a version behind the name is left out"


def test_results_are_none_one_value_or_a_tuple(server: ZmqWorld) -> None:
    sim = server.sim()
    hinge = sim.getObject("/hinge")
    assert sim.addLog(sim.verbosity_scriptinfos, "hello") is None
    assert isinstance(sim.getJointPosition(hinge), float)
    assert isinstance(sim.getObjectMatrix(hinge, -1), list)
    result, distance, point, handle, normal = sim.readProximitySensor(sim.getObject("/nose"))
    assert (result, distance, point, handle, normal) == (0, 0.0, [0, 0, 0], -1, [0, 0, 0])


def test_shapes_made_and_removed_one_by_one_are_compiled_together(
    server: ZmqWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiles: list[int] = []
    compile_spec = recompile.compile_spec

    def counted(*arguments: Any) -> Any:
        compiles.append(1)
        return compile_spec(*arguments)

    monkeypatch.setattr(recompile, "compile_spec", counted)
    sim = server.sim()
    shapes: list[int] = []
    for number in range(20):
        shapes.append(sim.createPrimitiveShape(sim.primitiveshape_cuboid, [0.1, 0.1, 0.1]))
        sim.setObjectPosition(shapes[-1], -1, [number, 2, 3])
        sim.setShapeColor(shapes[-1], None, sim.colorcomponent_ambient_diffuse, [1, 0, 0])
        sim.setObjectAlias(shapes[-1], f"brick{number}")
    assert not compiles
    assert sim.getObjectPosition(sim.getObject("/brick19"), -1) == [19, 2, 3]
    assert len(compiles) == 1
    for shape in shapes:
        sim.removeObject(shape)
    assert len(compiles) == 1
    assert sim.getObjectPosition(sim.getObject("/box"), -1) == pytest.approx([1, 0, 0.5])
    assert len(compiles) == 2


def test_text_is_str_and_data_is_bytes(server: ZmqWorld) -> None:
    sim = server.sim()
    assert sim.getObjectAlias(sim.getObject("/box")) == "box"
    assert isinstance(sim.packTable([1, 2]), bytes)
    sim.setStringSignal("data", b"\x00\x01\xff")
    assert sim.getStringSignal("data") == b"\x00\x01\xff"
    sim.setStringSignal("data", "done")
    assert sim.getStringSignal("data") == "done"
    assert sim.getBufferSignal("data") == b"done"
    box = sim.getObject("/box")
    sim.writeCustomStringData(box, "note", "fragile")
    assert (sim.readCustomStringData(box, "note"), sim.readCustomDataBlock(box, "note")) == (
        "fragile",
        b"fragile",
    )
    sim.startSimulation()
    script = sim.getScript(sim.scripttype_childscript, sim.getObject("/arm"))
    assert sim.callScriptFunction("double", script, 21) == 42
    assert sim.callScriptFunction("say", script) == ("text", b"\x00\x01")


def test_floats_stand_for_handles_and_none_for_what_is_left_out(server: ZmqWorld) -> None:
    sim = server.sim()
    box = float(sim.getObject("/box"))
    assert sim.getObjectPosition(box, -1.0) == pytest.approx([1, 0, 0.5])
    dummy = sim.createDummy(0.01, None)
    assert sim.removeObjects([dummy, float(sim.createDummy(0.01))]) in (None, 1)


def test_errors_are_texts_with_the_words_that_programs_look_for(server: ZmqWorld) -> None:
    client = server.client()
    sim = client.require("sim")
    with pytest.raises(Exception, match=r"^in sim\.getObject: object does not exist: no object named '/nix'"):
        sim.getObject("/nix")
    with pytest.raises(Exception, match=r"^No such function: sim\.x"):
        client.call("sim.x", [])
    with pytest.raises(Exception, match=r"No such function: sim\.getObjectPositon; did you mean"):
        client.call("sim.getObjectPositon", [])
    with pytest.raises(Exception, match="there is no namespace 'simNix'; this server has sim, "):
        client.require("simNix")
    with pytest.raises(Exception, match="argument 1"):
        sim.getObjectPosition("box", -1)
    assert sim.getObject("/box") >= 0, "the client goes on"


def test_what_a_call_asks_for_is_done_before_its_answer(server: ZmqWorld) -> None:
    sim = server.sim()
    assert sim.getSimulationState() == sim.simulation_stopped
    sim.startSimulation()
    assert sim.getSimulationState() != sim.simulation_stopped
    with pytest.raises(Exception, match="only while the simulation is stopped"):
        sim.loadScene("/nix.ttt")
    sim.stopSimulation(True)
    assert sim.getSimulationState() == sim.simulation_stopped
    with pytest.raises(Exception, match=r"sim\.loadScene: .*nix\.ttt"):
        sim.loadScene("/nix.ttt")


def test_a_scene_that_cannot_be_loaded_is_this_calls_error(server: ZmqWorld) -> None:
    with pytest.raises(Exception, match=r"sim\.loadScene: .*"):
        server.sim().loadScene(b"VREP" + bytes(100))


def test_code_is_refused_unless_the_operator_allows_it(server: ZmqWorld) -> None:
    sim = server.sim()
    script = sim.getScript(sim.scripttype_childscript, sim.getObject("/arm"))
    for refused in (
        lambda: sim.executeScriptString("x = 1", script),
        lambda: sim.callScriptFunction("load", script, "x = 1"),
        lambda: sim.callScriptFunction("load\0", script, "x = 1"),
        lambda: sim.callScriptFunction("sim.executeScriptString", script, "x = 1", script),
        lambda: sim.callScriptFunction("simExecuteScriptString@arm", 1, "x = 1", script),
        lambda: sim.launchExecutable("/bin/true"),
        lambda: sim.loadPlugin("simIK"),
    ):
        with pytest.raises(Exception, match="--allow-code"):
            refused()
    server.world.parts.scripts.allows_code = True
    try:
        sim.startSimulation()
        assert sim.executeScriptString("return 7", script) == (0, 7)
    finally:
        server.world.parts.scripts.allows_code = False


def test_a_piece_of_lua_runs_in_the_sandbox_if_the_operator_allows_it(server: ZmqWorld) -> None:
    sim, raw = server.sim(), server.raw()
    sandbox = sim.getScript(sim.scripttype_sandbox)
    piece = "1 + 1, 'two'"
    assert raw.ask("", eval=piece)["err"].startswith(
        "in zmqRemoteApi.eval: the server runs no code of clients"
    )
    with pytest.raises(Exception, match="--allow-code"):
        sim.executeScriptString("x = 5", sandbox)
    server.world.parts.scripts.allows_code = True
    try:
        assert raw.ask("", eval=piece) == {"ret": [2, "two"]}
        assert sim.executeScriptString("x = 5 return sim.getObject('/box')", sandbox) == (
            0,
            sim.getObject("/box"),
        )
        assert raw.ask("", eval="y = x + 1 return y") == {"ret": [6]}, "it keeps its globals"
        assert "<name> expected" in raw.ask("", eval="for")["err"]
        assert "boom" in raw.ask("", eval="error('boom')")["err"]
        assert sim.getScriptName(sandbox) == ""
    finally:
        server.world.parts.scripts.allows_code = False


def test_a_script_object_stands_for_its_script(server: ZmqWorld) -> None:
    sim = server.sim()
    shelf = sim.getObject("/shelf/shelfScript")
    assert sim.getObjectType(shelf) == sim.sceneobject_script
    functions = sim.getScriptFunctions(shelf)
    assert functions.where() == "shelf"
    assert sim.callScriptFunction(shelf, "where") == "shelf", "CoppeliaSim 4.10 has the script first"


def test_the_metrics_name_functions_and_the_session_names_the_client(server: ZmqWorld) -> None:
    client = server.client()
    sim = client.require("sim")
    sim.getSimulationTimeStep()
    assert "sim.getSimulationTimeStep" in server.loop.service.metrics.command_times
    names = server.on_server(
        lambda: [session.name for session in server.loop.service.clients.sessions.values()]
    )
    assert f"python-{client.uuid[:8]}" in names


def test_program_version_is_one_of_coppeliasims(server: ZmqWorld) -> None:
    sim = server.sim()
    assert sim.getInt32Param(sim.intparam_program_version) >= 40600


def test_the_answer_to_an_old_client_says_what_to_do(server: ZmqWorld) -> None:
    import cbor2

    answer = server.raw().ask_bytes(cbor2.dumps({"func": "zmqRemoteApi.info", "args": ["sim"]}))
    assert answer["success"] is False
    assert "install coppeliasim-zmqremoteapi-client" in answer["error"]


def test_info_of_a_function_is_empty_so_that_clients_end(server: ZmqWorld) -> None:
    answer: Any = server.raw().ask("zmqRemoteApi.info", "sim.getObject")
    assert answer == {"ret": [{}]}


def test_scripts_have_paths(server: ZmqWorld) -> None:
    sim = server.sim()
    script = sim.getObject("/arm/Script")
    assert script == sim.getScript(sim.scripttype_childscript, sim.getObject("/arm"))
    assert sim.getObject("/arm/Script[1]", {"noError": True}) == -1
    assert sim.getObject("/nix/Script", {"noError": True}) == -1
    sim.startSimulation()
    assert sim.callScriptFunction("double", script, 4) == 8


def test_a_signed_force_pushes_in_its_direction(server: ZmqWorld) -> None:
    sim = server.sim()
    hinge = sim.getObject("/hinge")
    sim.setStepping(True)
    sim.startSimulation()
    sim.setObjectInt32Param(hinge, sim.jointintparam_dynctrlmode, sim.jointdynctrl_force)
    sim.setJointTargetForce(hinge, -0.5, True)
    for _ in range(4):
        sim.step()
    assert sim.getJointPosition(hinge) < 0


def test_parameters_that_programs_read_and_set(server: ZmqWorld) -> None:
    sim = server.sim()
    before = sim.getInt32Param(sim.intparam_idle_fps)
    sim.setInt32Param(sim.intparam_idle_fps, 0)
    sim.setInt32Param(sim.intparam_idle_fps, before)
    assert isinstance(sim.getStringParam(sim.stringparam_scenedefaultdir), str)
    assert isinstance(sim.getStringParam(sim.stringparam_modeldefaultdir), str)


def test_the_server_looks_for_the_next_call_of_a_client_that_calls_at_once(
    server: ZmqWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    client, expected = server.raw(), []

    def calls_expected() -> int:
        return server.on_server(lambda: len(expected))  # after the answer is sent, it expects another call

    monkeypatch.setattr(server.loop.service.queue.open_sockets(), "expect", lambda: expected.append("a call"))
    monkeypatch.setattr(gateway, "LOOK", 1000.0)
    client.ask("sim.getSimulationTime")
    assert calls_expected() == 0, "the first call follows no answer"
    for _ in range(2):
        client.ask("sim.getSimulationTime")
    assert calls_expected() == 2
    monkeypatch.setattr(gateway, "LOOK", 0.0)
    client.ask("sim.getSimulationTime")
    assert calls_expected() == 2, "this one has come late"
