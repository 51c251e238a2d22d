"""The project's version, written here alone: packages, programs and messages take it from here."""

__version__ = "0.1.0"
