"""Completion scripts for bash, zsh and fish, which those shells read by ``source``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from .completion import FILE, FOLDER, Flag, Program, Value

HEAD = "# made by: python -m simx_client completion {shell}"


def bash(programs: Sequence[Program]) -> Iterator[str]:
    """Yield the lines for bash 4 and newer, with or without the package bash-completion."""
    yield HEAD.format(shell="bash")
    for program in _all(programs):
        yield f"{_function(program)}() {{"
        yield '    local cur="${COMP_WORDS[COMP_CWORD]}" prev="${COMP_WORDS[COMP_CWORD-1]}"'
        yield "    COMPREPLY=()"
        if program.commands:
            words = " ".join(program.commands)
            yield f'    if ((COMP_CWORD == 1)); then COMPREPLY=($(compgen -W "{words}" -- "$cur")); return; fi'
            yield '    case "${COMP_WORDS[1]}" in'
            for name, (_, command) in program.commands.items():
                yield f"        {name}) {_function(command)} ;;"
            yield "    esac"
        else:
            yield '    case "$prev" in'
            for flag in program.flags:
                if flag.value is not None:
                    yield f"        {'|'.join(flag.spellings)}) {_bash_reply(flag.value)} return ;;"
            yield "    esac"
            flags = " ".join(word for flag in program.flags for word in flag.spellings)
            yield f'    if [[ "$cur" == -* ]]; then COMPREPLY=($(compgen -W "{flags}" -- "$cur")); return; fi'
            yield f"    {_bash_reply(program.value) or ':'}"
        yield "}"
    for program in programs:
        yield f"complete -o filenames -F {_function(program)} {program.name}"


def _bash_reply(value: Value) -> str:
    asked = [f'compgen -W "{" ".join(value.words)}" -- "$cur"'] if value.words else []
    if value.path:
        asked.append(f'compgen -{"f" if value.path == FILE else "d"} -- "$cur"')
    return f"COMPREPLY=($({'; '.join(asked)}));" if asked else ""


def zsh(programs: Sequence[Program]) -> Iterator[str]:
    """Yield the lines for zsh, after ``compinit``."""
    yield HEAD.format(shell="zsh")
    for program in _all(programs):
        yield f"{_function(program)}() {{"
        yield "    local -a flags commands"
        if program.commands:
            yield "    if (( CURRENT == 2 )); then"
            yield f"        commands=({_zsh_described((name, help) for name, (help, _) in program.commands.items())})"
            yield "        _describe command commands; return"
            yield "    fi"
            yield "    case $words[2] in"
            for name, (_, command) in program.commands.items():
                yield f"        ({name}) {_function(command)} ;;"
            yield "    esac"
        else:
            yield "    case $words[CURRENT-1] in"
            for flag in program.flags:
                if flag.value is not None:
                    yield f"        ({'|'.join(flag.spellings)}) {_zsh_reply(flag.value)} return ;;"
            yield "    esac"
            yield "    if [[ $words[CURRENT] == -* ]]; then"
            described = ((word, flag.help) for flag in program.flags for word in flag.spellings)
            yield f"        flags=({_zsh_described(described)})"
            yield "        _describe flag flags; return"
            yield "    fi"
            yield f"    {_zsh_reply(program.value) or ':'}"
        yield "}"
    for program in programs:
        yield f"compdef {_function(program)} {program.name}"


def _zsh_reply(value: Value) -> str:
    asked = [f"compadd -- {' '.join(value.words)};"] if value.words else []
    if value.path:
        asked.append("_files;" if value.path == FILE else "_files -/;")
    return " ".join(asked)


def _zsh_described(items: Iterable[tuple[str, str]]) -> str:
    return " ".join(_quoted(f"{word}:{help}" if help else word) for word, help in items)


def fish(programs: Sequence[Program]) -> Iterator[str]:
    """Yield the lines for fish 3 and newer."""
    yield HEAD.format(shell="fish")
    for program in programs:
        yield f"complete -c {program.name} -f"
        if not program.commands:
            yield from _fish_words(program, program.name, "")
        for name, (help, command) in program.commands.items():
            yield f"complete -c {program.name} -n __fish_use_subcommand -a {name} -d {_quoted(help)}"
            yield from _fish_words(
                command, program.name, f" -n {_quoted(f'__fish_seen_subcommand_from {name}')}"
            )


def _fish_words(program: Program, name: str, condition: str) -> Iterator[str]:
    for flag in program.flags:
        yield f"complete -c {name}{condition}{_fish_spellings(flag)}{_fish_value(flag.value)} -d {_quoted(flag.help)}"
    if program.value.words:
        yield f"complete -c {name}{condition} -a {_quoted(' '.join(program.value.words))}"
    if program.value.path:
        yield f"complete -c {name}{condition} {_fish_path(program.value.path)}"


def _fish_spellings(flag: Flag) -> str:
    return "".join(
        f" -l {word[2:]}" if word.startswith("--") else f" -s {word[1:]}" for word in flag.spellings
    )


def _fish_value(value: Value | None) -> str:
    if value is None:
        return ""
    if value.path and not value.words:
        return f" -r {_fish_path(value.path)}"
    return f" -x -a {_quoted(' '.join(value.words))}" if value.words else " -x"


def _fish_path(path: str) -> str:
    return "-a '(__fish_complete_directories)'" if path == FOLDER else "-F"


def _all(programs: Iterable[Program]) -> Iterator[Program]:
    """Yield each program after its commands."""
    for program in programs:
        yield from _all(command for _, command in program.commands.values())
        yield program


def _function(program: Program) -> str:
    return "_" + re.sub(r"\W", "_", program.name)


def _quoted(text: str) -> str:
    """Quote a text for bash, zsh and fish, in which a quote ends a quoted text."""
    return "'" + text.replace("'", "'\\''") + "'"
