"""What mkdocs needs beyond the pages as they are: the README as a page, and fences without file names.

Named in mkdocs.yml. The pages are written for the repository, where they are read with their links as they stand.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

START = "start.md"
"""The README's page. Its own name would take the place of index.md."""


def on_config(config: Any) -> Any:
    """Take the address of the site and of the repository from pyproject.toml, once they are there."""
    project = Path(config["config_file_path"]).with_name("pyproject.toml").read_text(encoding="utf-8")
    urls: dict[str, str] = tomllib.loads(project)["project"].get("urls", {})
    config["site_url"], config["repo_url"] = urls.get("Documentation", ""), urls.get("Repository", "")
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add the README."""
    readme = Path(config["config_file_path"]).with_name("README.md").read_text(encoding="utf-8")
    a_file: Any = type(next(iter(files)))  # mkdocs' class, without importing what only a site needs
    files.append(a_file.generated(config, START, content=re.sub(r"\]\(docs/", "](", readme)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Links to the README's page and to nothing else outside docs/; fences and lists as Markdown wants them."""
    up = "../" * page.file.src_uri.count("/")
    outside = re.escape(f"{up}../")
    markdown = markdown.replace(f"]({up}../README.md", f"]({up}{START}")
    markdown = re.sub(rf"(?<!!)\[([^]]+)\]\({outside}[^)]+\)", r"\1", markdown)
    markdown = re.sub(r"^(```\w+) .+$", r"\1", markdown, flags=re.MULTILINE)
    return re.sub(r"^((?![*|\d-]|  )\S.*)\n(?=\* )", r"\1\n\n", markdown, flags=re.MULTILINE)
