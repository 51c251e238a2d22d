"""ROS 2 over Zenoh: the server is a node for nodes with `rmw_zenoh_cpp`, without a bridge and without ROS.

`endpoints.py` describes what the node offers, and is where further topics start. `content/` has what every scene
offers; `simx_server/ros2_messages/` the layouts of the messages; `wire/` how rmw_zenoh writes keys, tokens and
attachments, and the Zenoh session, which has a separate thread. `gateway.py` joins them on the physics thread: after
each simulation step it publishes where someone listens; `client.py` executes the calls that messages become, as those
of any other client.
"""
