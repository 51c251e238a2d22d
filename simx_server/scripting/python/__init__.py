"""Scripts in Python: each in a confined process. The modules ``python_*`` run in that process."""
