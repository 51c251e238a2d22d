"""``python -m simx_server.viewer``: the page in a process of its own."""

import sys

from .page.command import main

sys.exit(main())
