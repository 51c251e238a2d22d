"""Completion scripts for bash, zsh and fish, which those shells read by ``source``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from .completion_words import FOLDER, Flag, Program, Value

HEAD = "# made by: python -m simx_client completion {shell}"
Words = Iterable[tuple[str, str]]
"""With their descriptions."""


class _Bash:
    """For bash 4 and newer, with or without the package bash-completion."""

    NAME = "bash"
    BEGIN = ('local cur="${COMP_WORDS[COMP_CWORD]}" prev="${COMP_WORDS[COMP_CWORD-1]}"', "COMPREPLY=()")
    IS_COMMAND, IS_FLAG = "((COMP_CWORD == 1))", '[[ "$cur" == -* ]]'
    COMMAND, BEFORE, CASE = '"${COMP_WORDS[1]}"', '"$prev"', "{})"
    REGISTER = "complete -o filenames -F {} {}"

    def offer(self, condition: str, kind: str, words: Words) -> Iterator[str]:
        asked = self.reply(Value(tuple(word for word, _ in words)))
        yield f"if {condition}; then {asked} return; fi"

    def reply(self, value: Value) -> str:
        asked = [f'compgen -W "{" ".join(value.words)}" -- "$cur"'] if value.words else []
        if value.path:
            asked.append(f'compgen -{"d" if value.path == FOLDER else "f"} -- "$cur"')
        return f"COMPREPLY=($({'; '.join(asked)}));" if asked else ""


class _Zsh(_Bash):
    """For zsh, after ``compinit``."""

    NAME = "zsh"
    BEGIN = ("local -a flags commands",)
    IS_COMMAND, IS_FLAG = "(( CURRENT == 2 ))", "[[ $words[CURRENT] == -* ]]"
    COMMAND, BEFORE, CASE = "$words[2]", "$words[CURRENT-1]", "({})"
    REGISTER = "compdef {} {}"

    def offer(self, condition: str, kind: str, words: Words) -> Iterator[str]:
        described = " ".join(_quoted(f"{word}:{help}" if help else word) for word, help in words)
        yield f"if {condition}; then"
        yield f"    {kind}s=({described})"
        yield f"    _describe {kind} {kind}s; return"
        yield "fi"

    def reply(self, value: Value) -> str:
        asked = [f"compadd -- {' '.join(value.words)};"] if value.words else []
        if value.path:
            asked.append("_files -/;" if value.path == FOLDER else "_files;")
        return " ".join(asked)


def bash(programs: Sequence[Program]) -> Iterator[str]:
    return _functions(programs, _Bash())


def zsh(programs: Sequence[Program]) -> Iterator[str]:
    return _functions(programs, _Zsh())


def _functions(programs: Sequence[Program], shell: _Bash) -> Iterator[str]:
    """Yield the lines: a function for each command, then for its program."""
    yield HEAD.format(shell=shell.NAME)
    for program in programs:
        for each in (*(command for _, command in program.commands.values()), program):
            yield f"{_function(each)}() {{"
            yield from (f"    {line}" for line in (*shell.BEGIN, *_body(each, shell)))
            yield "}"
    for program in programs:
        yield shell.REGISTER.format(_function(program), program.name)


def _body(program: Program, shell: _Bash) -> Iterator[str]:
    if program.commands:
        commands = ((name, help) for name, (help, _) in program.commands.items())
        yield from shell.offer(shell.IS_COMMAND, "command", commands)
        yield f"case {shell.COMMAND} in"
        for name, (_, command) in program.commands.items():
            yield f"    {shell.CASE.format(name)} {_function(command)} ;;"
        yield "esac"
        return
    yield f"case {shell.BEFORE} in"
    for flag in program.flags:
        if flag.value is not None:
            yield f"    {shell.CASE.format('|'.join(flag.spellings))} {shell.reply(flag.value)} return ;;"
    yield "esac"
    flags = ((word, flag.help) for flag in program.flags for word in flag.spellings)
    yield from shell.offer(shell.IS_FLAG, "flag", flags)
    yield shell.reply(program.value) or ":"


def fish(programs: Sequence[Program]) -> Iterator[str]:
    """Yield the lines for fish 3 and newer."""
    yield HEAD.format(shell="fish")
    for program in programs:
        start = f"complete -c {program.name}"
        yield f"{start} -f"
        if not program.commands:
            yield from _fish_words(program, start)
        for name, (help, command) in program.commands.items():
            yield f"{start} -n __fish_use_subcommand -a {name} -d {_quoted(help)}"
            yield from _fish_words(command, f"{start} -n {_quoted(f'__fish_seen_subcommand_from {name}')}")


def _fish_words(program: Program, start: str) -> Iterator[str]:
    for flag in program.flags:
        yield f"{start}{_fish_flag(flag)} -d {_quoted(flag.help)}"
    if program.value.words:
        yield f"{start} -a {_quoted(' '.join(program.value.words))}"
    if program.value.path:
        yield f"{start} {_fish_path(program.value.path)}"


def _fish_flag(flag: Flag) -> str:
    text = "".join(
        f" -l {word[2:]}" if word.startswith("--") else f" -s {word[1:]}" for word in flag.spellings
    )
    if flag.value is None:
        return text
    if flag.value.path and not flag.value.words:
        return f"{text} -r {_fish_path(flag.value.path)}"
    return f"{text} -x" + (f" -a {_quoted(' '.join(flag.value.words))}" if flag.value.words else "")


def _fish_path(path: str) -> str:
    return "-a '(__fish_complete_directories)'" if path == FOLDER else "-F"


def _function(program: Program) -> str:
    return "_" + re.sub(r"\W", "_", program.name)


def _quoted(text: str) -> str:
    """Quote a text for bash, zsh and fish, in which a quote ends a quoted text."""
    return "'" + text.replace("'", "'\\''") + "'"
