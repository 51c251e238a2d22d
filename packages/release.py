"""Make a release from one number, and hold its places together: ``python packages/release.py COMMAND``.

    new VERSION     write version, changelog and citation, commit them and tag the commit; nothing is pushed
    check TAG       fail if the tag is not the version of the tree, or a place disagrees
    notes           print the changelog's section of the version
    minor           print the version as the site names it: 1.2 for 1.2.3
    address URL     write the address of the repository, https://github.com/OWNER/NAME, into all places that need it

The version is in simx_client/protocol/version.py, the address in pyproject.toml (``project.urls``).
"""

from __future__ import annotations

import argparse
import datetime
import re
import subprocess
import sys
import tomllib
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
VERSION = Path("simx_client/protocol/version.py")
CHANGELOG = Path("CHANGELOG.md")
CITATION = Path("CITATION.cff")
PROJECT = Path("pyproject.toml")
OWNERS = Path(".github/CODEOWNERS")

_UNRELEASED = "## Unreleased\n"
_ADDRESS = re.compile(r"https://github\.com/(?P<owner>[\w.-]+)/(?P<name>[\w.-]+)")


class Wrong(Exception):
    """What must be put right before a release; the text says how."""


class Tree:
    """The files of a checkout that have the version or the address."""

    def __init__(self, root: Path = REPOSITORY) -> None:
        self.root = root

    def read(self, file: Path) -> str:
        return (self.root / file).read_text(encoding="utf-8")

    def change(self, file: Path, pattern: str, new: str) -> None:
        """Replace the only place where a pattern with one group matches, which is the text to replace."""
        text = self.read(file)
        found = list(re.finditer(pattern, text, re.MULTILINE))
        if len(found) != 1:
            raise Wrong(f"{file} has {len(found)} places that match {pattern}, and should have one")
        start, end = found[0].span(1)
        (self.root / file).write_text(text[:start] + new + text[end:], encoding="utf-8", newline="\n")

    @property
    def version(self) -> str:
        found = re.search(r'^__version__ = "(.+)"$', self.read(VERSION), re.MULTILINE)
        if found is None:
            raise Wrong(f"{VERSION} has no version")
        return found[1]

    @property
    def address(self) -> str:
        """The address of the repository; empty while there is none."""
        return tomllib.loads(self.read(PROJECT))["project"].get("urls", {}).get("Repository", "")

    def section(self, heading: str) -> str:
        """Return the text of a section of the changelog; its heading starts with these words."""
        found = re.search(
            rf"^## {re.escape(heading)}\b.*\n((?:(?!## ).*\n?)*)", self.read(CHANGELOG), re.MULTILINE
        )
        return found[1].strip() if found else ""

    def git(self, *words: str) -> str:
        done = subprocess.run(["git", *words], cwd=self.root, capture_output=True, text=True)
        if done.returncode:
            raise Wrong(f"git {' '.join(words)}: {done.stderr.strip()}")
        return done.stdout.strip()


def new(tree: Tree, version: str, date: str) -> str:
    """Write a version into all places, commit and tag; return what to do next."""
    if not re.fullmatch(r"\d+\.\d+\.\d+(rc\d+)?", version):
        raise Wrong(f"{version} is not a version such as 1.2.3 or 1.2.3rc1")
    if _key(version) <= _key(tree.version):
        raise Wrong(f"{version} is not newer than {tree.version}")
    if not tree.section("Unreleased"):
        raise Wrong(f"{CHANGELOG} has nothing under Unreleased")
    if tree.git("status", "--porcelain"):
        raise Wrong("the checkout has changes that are not committed")
    tree.change(VERSION, r'^__version__ = "(.+)"$', version)
    tree.change(CHANGELOG, rf"^({_UNRELEASED})", f"{_UNRELEASED}\n## {version} - {date}\n")
    tree.change(CITATION, r"^version: (.+)$", version)
    tree.change(CITATION, r"^date-released: (.+)$", date)
    tree.git("commit", "--quiet", "--all", "--message", f"Version {version}")
    tree.git("tag", "--annotate", f"v{version}", "--message", f"simx {version}")
    return f"tagged v{version}; to publish it: git push --atomic origin HEAD v{version}"


def check(tree: Tree, tag: str) -> list[str]:
    """Return what disagrees with a tag."""
    version = tree.version
    wrong = [] if tag == f"v{version}" else [f"the tag is {tag}, the version of the tree {version}"]
    if not tree.section(f"{version} - "):
        wrong.append(f"{CHANGELOG} has no section {version} with a date")
    if f"\nversion: {version}\n" not in tree.read(CITATION):
        wrong.append(f"{CITATION} has another version")
    return wrong + check_address(tree)


def check_address(tree: Tree) -> list[str]:
    """Return the places whose address is not that of pyproject.toml."""
    if not tree.address:
        return ["no address yet: python packages/release.py address https://github.com/OWNER/NAME"]
    wrong = [] if f'\nrepository-code: "{tree.address}"\n' in tree.read(CITATION) else [str(CITATION)]
    if _owners(tree.address) not in tree.read(OWNERS):
        wrong.append(str(OWNERS))
    return [f"{file} has another address than {PROJECT}" for file in wrong]


def set_address(tree: Tree, address: str) -> None:
    """Write the address of the repository, and what follows from it, into all places."""
    found = _ADDRESS.fullmatch(address)
    if found is None:
        raise Wrong(f"{address} is not an address such as https://github.com/OWNER/NAME")
    urls = {
        "Repository": address,
        "Documentation": f"https://{found['owner'].lower()}.github.io/{found['name']}/",
        "Changelog": f"{address}/blob/main/{CHANGELOG}",
        "Issues": f"{address}/issues",
    }
    table = "".join(f'{name} = "{url}"\n' for name, url in urls.items())
    if tree.address:
        tree.change(PROJECT, r"^\[project\.urls\]\n((?:\w+ = .*\n)+)", table)
        tree.change(CITATION, r'^repository-code: "(.+)"$', address)
    else:
        tree.change(PROJECT, r"^()\[project\.scripts\]$", f"[project.urls]\n{table}\n")
        tree.change(CITATION, r"^()license: ", f'repository-code: "{address}"\n')
    note = tree.read(OWNERS).partition("\n")[0]
    (tree.root / OWNERS).write_text(f"{note}\n{_owners(address)}\n", encoding="utf-8", newline="\n")


def _owners(address: str) -> str:
    found = _ADDRESS.fullmatch(address)
    return f"* @{found['owner'] if found else ''}"


def _key(version: str) -> tuple[int, ...]:
    """Order versions; a candidate (rc) comes before its version."""
    numbers = [int(each) for each in re.findall(r"\d+", version)]
    return (*numbers, sys.maxsize) if "rc" not in version else tuple(numbers)


def main(arguments: list[str] | None = None, tree: Tree | None = None) -> int:
    """Run a command; return 1 with reasons on standard error if something is wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    making = commands.add_parser("new")
    making.add_argument("version")
    making.add_argument("--date", default=datetime.datetime.now(datetime.UTC).date().isoformat())
    commands.add_parser("check").add_argument("tag")
    commands.add_parser("address").add_argument("url")
    for name in ("notes", "minor"):
        commands.add_parser(name)
    options = parser.parse_args(arguments)
    tree = tree or Tree()
    try:
        if options.command == "new":
            sys.stdout.write(new(tree, options.version, options.date) + "\n")
        elif options.command == "address":
            set_address(tree, options.url)
        elif options.command == "check":
            if wrong := check(tree, options.tag):
                raise Wrong("\n".join(wrong))
        elif options.command == "notes":
            sys.stdout.write(tree.section(tree.version) + "\n")
        else:
            sys.stdout.write(".".join(tree.version.split(".")[:2]) + "\n")
    except Wrong as error:
        sys.stderr.write(f"{error}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
