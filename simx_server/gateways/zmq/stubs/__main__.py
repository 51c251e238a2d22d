"""Write the stubs into ``packages/types``."""

from .files import write

write()
