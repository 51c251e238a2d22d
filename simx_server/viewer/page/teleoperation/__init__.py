"""Teleoperation in the web viewer: keys, a gamepad and a gizmo move an arm; buttons mark demonstrations."""
