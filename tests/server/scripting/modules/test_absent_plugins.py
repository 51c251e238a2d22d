"""Modules in place of plug-ins that the server does not have."""

from __future__ import annotations

from types import ModuleType

import pytest

from simx_server.scripting.modules.absent import ADVICE, stand_in


@pytest.mark.parametrize("name", ADVICE)
def test_a_function_of_a_missing_plugin_fails_in_python_when_it_is_called(name: str) -> None:
    text = stand_in(name, "python")
    assert text is not None
    module = ModuleType(name)
    exec(text, module.__dict__)
    with pytest.raises(RuntimeError, match=f"{name}.go: this server has no plug-in {name}: "):
        module.go(1, option=2)
    assert not hasattr(module, "__path__")


def test_other_modules_have_no_stand_in() -> None:
    assert stand_in("simMine", "lua") is None
