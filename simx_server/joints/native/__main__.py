"""Print in which form physics steps run: ``python -m simx_server.joints.native``."""

import sys

from simx_server.compiled import HOW_TO_COMPILE

from .loading import form

if __name__ == "__main__":
    module, reason = form()
    sys.stdout.write(
        f"{reason}\n" if module is not None else f"in Python, slower: {reason}; {HOW_TO_COMPILE}\n"
    )
