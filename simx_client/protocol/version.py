"""The project's version; packages, programs and messages use this one."""

__version__ = "0.4.0"
