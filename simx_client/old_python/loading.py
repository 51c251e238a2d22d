"""Select and run the files that are Python 2: the script and its modules.

If the script is Python 2, so are all its modules that are not installed: a program that prints without
brackets also divides integers, and the module beside the script may show only the latter. If the script is
Python 3, a module is converted only if Python 3 cannot run it.
"""

from __future__ import annotations

import ast
import logging
import os
import sysconfig
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType

from simx_client.launch.after_import import found_by_others

from . import recognise
from .convert import CannotConvert, Converted, NoConverter, beside, decode, to_python3

logger = logging.getLogger(__name__)

_INSTALLED = tuple(
    os.path.join(os.path.realpath(folder), "")
    for folder in (
        *(sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")),
        Path(__file__).parents[1],  # this package
        # --embed imports it; in a source tree it is beside this package.
        Path(__file__).parents[1].with_name("simx_server"),
    )
)
_INSTALLED_ANYWHERE = {"site-packages", "dist-packages"}


class IsPython2(Exception):
    """A file is Python 2 and could not be converted; the text is the whole sentence for the user."""


def convert_if_python2(
    source: bytes, path: str, *, for_sure: bool = False, in_package: bool = False
) -> Converted | None:
    """Return the converted file, None if Python 3 can run it unchanged.

    Args:
        for_sure: treat the file as Python 2 even if Python 3 could run it.

    Raises:
        SyntaxError: neither version can run it; the error of Python 3.
        IsPython2: it is Python 2 and cannot be converted.
    """
    text = decode(source)
    finding: recognise.Finding | None = None
    stopped: SyntaxError | None = None
    try:
        tree = ast.parse(source, path)
        finding = recognise.from_names(tree, text)
        if finding is None and in_package:
            finding = recognise.from_imports(tree, text, beside(path))
    except SyntaxError as error:
        stopped, finding = error, recognise.from_syntax_error(error, text)
    if not (for_sure or finding or stopped):
        return None
    try:
        return to_python3(text, path, in_package=in_package)
    except NoConverter as error:
        reason, advice = "fissix is not installed", str(error)
    except CannotConvert as error:
        reason, advice = str(error), "mend it by hand and run it again"
    if finding is not None:
        raise IsPython2(
            f"{path}, line {finding.line}, is Python 2 ({finding.construct}) and could not be converted "
            f"({reason}); {advice}"
        )
    if stopped is not None:
        raise stopped
    return None


class Python2Finder(MetaPathFinder):
    """Lets other finders find a module and converts it while loading if it belongs to the script."""

    def __init__(self, *, script_is_python2: bool) -> None:
        self._script_is_python2 = script_is_python2

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        spec = found_by_others(self, fullname, path, target)
        if spec is not None and type(spec.loader) is SourceFileLoader and not _is_installed(spec.loader.path):
            spec.loader = _Loader(fullname, spec.loader.path, for_sure=self._script_is_python2)
        return spec


class _Loader(SourceFileLoader):
    def __init__(self, fullname: str, path: str, *, for_sure: bool) -> None:
        super().__init__(fullname, path)
        self._for_sure = for_sure

    def get_code(self, fullname: str) -> CodeType | None:
        """Return the module's code. Converted code is not cached: plain Python would load the cache."""
        path = self.get_filename(fullname)
        in_package = "." in fullname or self.is_package(fullname)
        converted = convert_if_python2(
            self.get_data(path), path, for_sure=self._for_sure, in_package=in_package
        )
        if converted is None:
            return super().get_code(fullname)
        logger.info("%s is Python 2 and was converted in memory", path)
        return converted.code


def _is_installed(path: str) -> bool:
    real = os.path.realpath(path)
    return real.startswith(_INSTALLED) or not _INSTALLED_ANYWHERE.isdisjoint(real.split(os.sep))
