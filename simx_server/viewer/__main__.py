"""``python -m simx_server.viewer``: the web viewer in a separate process."""

import sys

from .page.command import main

sys.exit(main())
