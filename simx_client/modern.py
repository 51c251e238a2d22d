"""Former name of `simx_client.client`: programs that import from here run unchanged."""

from .client import *  # noqa: F403
from .client import __all__ as __all__
