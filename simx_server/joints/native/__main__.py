"""Print in which form physics steps run: ``python -m simx_server.joints.native``."""

import sys

from .loading import form

if __name__ == "__main__":
    module, reason = form()
    sys.stdout.write(f"{reason if module is not None else f'in Python: {reason}'}\n")
