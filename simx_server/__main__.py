"""``python -m simx_server`` is ``simx-server``."""

from __future__ import annotations

import sys

from simx_server.app.cli import main

if __name__ == "__main__":
    sys.exit(main())
