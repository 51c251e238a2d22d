"""Print docs/llms.txt, the list of pages for agents (https://llmstxt.org), from docs/index.md."""

from __future__ import annotations

import re
from pathlib import Path

FOLDER = Path(__file__).parent
HEAD = """\
# simx

> A server that steps MuJoCo and answers programs of V-REP and CoppeliaSim: legacy remote API, ZeroMQ remote API,
> PyRep, ROS 2. It reads .ttt, MJCF and URDF scenes. `simx mcp` offers it to agents (agents.md).
"""


def text() -> str:
    """Return the list."""
    index = (FOLDER / "index.md").read_text(encoding="utf-8").partition("\n## ")[0]
    joined = re.sub(r"\n {3,}(?=\S)", " ", index)  # entries of two lines
    parts = [HEAD]
    for line in joined.splitlines():
        if section := re.fullmatch(r"\*\*(.+)\*\*", line):
            parts.append(f"\n## {section[1]}\n\n")
        elif entry := re.fullmatch(r"\d+\. (\[.+)", line):
            parts.append(f"- {entry[1]}\n")
    return "".join(parts)


if __name__ == "__main__":
    print(text(), end="")
