"""How long a process had to wait for a processor: limits of time must not end what a busy machine holds up."""

from pathlib import Path


def delay(process_id: int) -> float:
    """Return the seconds in which a process was ready and had no processor; 0 where the system does not count them.

    Its main thread counts. A process that has ended has 0 too.
    """
    try:
        return int(Path(f"/proc/{process_id}/schedstat").read_text("ascii").split()[1]) / 1e9
    except (OSError, IndexError, ValueError):
        return 0.0
