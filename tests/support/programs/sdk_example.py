# pyright: reportMissingImports=false
"""Run a program that uses the package zenoh-ros2-sdk, with the types of `sdk_definitions.py`.

python sdk_example.py PORT PROGRAM [ARGUMENT...]
"""

from __future__ import annotations

import os
import runpy
import sys
import tempfile
from pathlib import Path

from sdk_definitions import write_definitions
from zenoh_ros2_sdk.message_registry import get_registry
from zenoh_ros2_sdk.session import ZenohSession

code: object = 0
with tempfile.TemporaryDirectory() as folder:
    write_definitions(Path(folder))
    get_registry(folder)
    port = sys.argv[1]
    ZenohSession.get_instance("127.0.0.1", int(port))  # the registry would take the default port
    sys.argv = [*sys.argv[2:], "--port", port]
    try:
        runpy.run_path(sys.argv[0], run_name="__main__")
    except SystemExit as end:
        code = end.code
sys.stdout.flush()
os._exit(code if isinstance(code, int) else 0)  # the SDK's threads do not end by themselves
