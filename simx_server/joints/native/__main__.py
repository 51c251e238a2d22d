"""Print in which form physics steps run: ``python -m simx_server.joints.native``."""

import sys

from .loading import HOW_TO_COMPILE, form

if __name__ == "__main__":
    module, reason = form()
    sys.stdout.write(
        f"{reason}\n" if module is not None else f"in Python, slower: {reason}; {HOW_TO_COMPILE}\n"
    )
