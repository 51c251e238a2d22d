"""Stand-ins for plug-ins that connect other programs: scripts run on, nothing is sent, and the log says so once."""

from __future__ import annotations

import pytest
from sim_api_calls import ScriptWorld, world

from simx_server.ros2_messages import BUILT_IN
from simx_server.sim_api.ros2.messages import default_message, supported_messages

__all__ = ["world"]


def told(world: ScriptWorld, words: str) -> int:
    return sum(words in line for line in world.parts.status_bar.messages)


def test_ros_accepts_what_scripts_publish_and_says_once_that_it_goes_nowhere(world: ScriptWorld) -> None:
    first, second, third = world.lua(
        """
        local pub = simROS.advertise('/pose', 'geometry_msgs/PoseStamped')
        simROS.publisherTreatUInt8ArrayAsString(pub)
        local sub = simROS.subscribe('/cmd', 'std_msgs/Float64', 'callback')
        for i = 1, 3 do simROS.publish(pub, {header = {stamp = simROS.getTime()}}) end
        simROS.sendTransform({child_frame_id = 'a'}) simROS.shutdownPublisher(pub) simROS.shutdownSubscriber(sub)
        return pub, sub, simExtRosInterface_advertise('/old', 'std_msgs/Bool')
        """
    )
    assert len({first, second, third}) == 3, "handles differ"
    assert told(world, "ROS is not there") == 1


def test_parameters_of_ros_are_those_that_the_script_has_set(world: ScriptWorld) -> None:
    assert world.lua("return simROS.getParamDouble('wheel', 0.2)") == [False, 0.2]
    world.lua(
        "simROS.setParamDouble('wheel', 0.5) simROS.setParamString('name', 'a') simROS.setParamInt('n', 3)"
    )
    world.lua("simROS.setParamBool('on', true)")
    assert world.lua("return simROS.getParamDouble('wheel', 0.2)") == [True, 0.5]
    assert world.lua("return simROS.getParamString('name'), simROS.hasParam('n')") == [True, True]
    assert world.lua("return simROS.getParamInt('name', 7)") == [False, 7]
    assert world.lua("return simROS.getParamBool('on', false)") == [True, True]
    world.lua("simROS.deleteParam('n')")
    assert world.value("simROS.hasParam('n')") is False


def test_ros_2_gives_messages_to_fill_in(world: ScriptWorld) -> None:
    world.lua(
        """
        local pub = simROS2.createPublisher('/odom', 'nav_msgs/msg/Odometry')
        local message = simROS2.createInterface('nav_msgs/msg/Odometry')
        message.pose.pose.position.x = 1
        message.header.stamp = simROS2.getTime()
        simROS2.publish(pub, message)
        simROS2.createSubscription('/cmd_vel', 'geometry_msgs/msg/Twist', function(msg) end, 0, {depth = 1})
        """
    )
    assert world.value("#simROS2.createInterface('nav_msgs/msg/Odometry').pose.covariance") == 36
    assert world.value("#simROS2.supportedInterfaces()") == len(supported_messages(BUILT_IN))
    assert world.value("simROS2.getInterfaceConstants('sensor_msgs/msg/Range').INFRARED") == 1
    assert world.value("next(simROS2.createInterface('my_msgs/msg/Own')) == nil") is True
    assert world.lua(
        "return simROS2.waitForService(simROS2.createClient('/s', 't'), 1), simROS2.call(1, {})"
    ) in (
        [False],
        [False, None],
    )
    assert told(world, "ROS 2 is not there (--ros2)") == 1


def test_times_of_ros_2(world: ScriptWorld) -> None:
    world.passes(1)
    assert world.value("simROS2.timeToFloat(simROS2.timeFromFloat(2.25))") == pytest.approx(2.25)
    assert world.value("simROS2.getSimulationTime().nanosec") == 50_000_000
    assert world.value("simROS2.timeFromFloat(5.01).nanosec") == 10_000_000  # not 1 ns less, a float's error
    assert world.value("simROS2.timeFromFloat(-0.5).sec") == -1
    world.fails("simROS2.timeToFloat({sec = 'x'})", "a table with the numbers sec and nanosec")


def test_the_old_plug_in_of_ros_gives_the_topic_back(world: ScriptWorld) -> None:
    assert world.lua(
        "return simExtROS_enablePublisher('t', 1, simros_strmcmd_get_joint_state, sim_handle_all, 0, ''),"
        "simExtROS_enableSubscriber('s', 1, nil, -1, -1, '')"
    ) == ["t", 1]


def test_sockets_send_to_nobody_and_receive_nothing(world: ScriptWorld) -> None:
    assert world.lua(
        """
        local context = simZMQ.ctx_new()
        local socket = simZMQ.socket(context, simZMQ.REP)
        local bound = simZMQ.bind(socket, 'tcp://*:23001')
        local got, data = simZMQ.recv(socket, simZMQ.DONTWAIT)
        local sent = simZMQ.send(socket, 'hello', 0)
        return bound, got, data, sent, simZMQ.errnum() == simZMQ.EAGAIN, simZMQ.close(socket), simZMQ.ctx_term(context)
        """
    ) == [0, -1, "", 5, True, 0, 0]
    assert told(world, "no ZeroMQ sockets") == 1


def test_devices_and_programs_that_are_not_there_say_so(world: ScriptWorld) -> None:
    assert world.lua("return simMTB.startServer('mtbServer', 1, '', {0,0,0,0}, {0,0})")[0] == -1
    assert world.value("simExtCHAI3D_start(0, 0.01, 0.2)") == -1
    assert world.value("simB0.pingResolver()") is False
    assert world.value("simB0.nodeCreate('node') ~= simB0.publisherCreate(1, 't')") is True


def test_answers_are_separate_tables(world: ScriptWorld) -> None:
    assert world.lua("local t = simMTB.getJoints(1) t[1] = 5 return simMTB.getJoints(1)[1]") == [0]


@pytest.mark.parametrize("kind", supported_messages(BUILT_IN))
def test_every_known_message_has_a_default(kind: str) -> None:
    assert isinstance(default_message(BUILT_IN, kind), dict)


def test_a_message_of_ros_1_is_known_by_both_of_its_names() -> None:
    assert (
        default_message(BUILT_IN, "std_msgs::Float64")
        == default_message(BUILT_IN, "std_msgs/Float64")
        == {"data": 0.0}
    )
    assert default_message(BUILT_IN, "no_msgs/Such") is None


def test_marks_for_the_ros_bridge_are_kept_with_their_object(world: ScriptWorld) -> None:
    world.lua(
        "cube = sim.getObject('/cube', {noError=true}) if cube == -1 then cube = sim.getObjectHandle('cube') end"
    )
    assert world.value("sim.extGetCustomDataFromHeader(cube, sim_ext_ros_bridge_quadrotor_data_main)") is None
    world.lua(
        "simExtSetFloatCustomDataFromHeader(cube, sim_ext_ros_bridge_quadrotor_data_tf_ratio, 0.5)"
        "sim.extSetIntCustomDataFromHeader(cube, sim_ext_ros_bridge_quadrotor_data_ctrl_mode, 1)"
        "sim.extSetFloatArrayCustomDataFromHeader(cube, sim_ext_ros_bridge_imu_data_main, {1, 2.5})"
    )
    found = [world.value(f"sim.extGetCustomDataFromHeader(cube, {header})") for header in (12, 13, 200)]
    assert found == [0.5, 1, 2.5]
    assert world.value("sim.readCustomDataBlockTags(cube)") is None
    assert told(world, "no ROS bridge") == 1
    world.fails("sim.extSetFloatCustomDataFromHeader(cube, nil, 1)", "header")
    world.fails("sim.extSetFloatCustomDataFromHeader(cube, 12, 1e300)", "single precision")
