"""Each function of the namespaces declares what it does."""

from __future__ import annotations

import re

import pytest

from simx_server import sim_api as api
from simx_server.sim_api import effects as declarations
from simx_server.sim_api.namespaces import effects, signatures

_CHANGING = re.compile(
    "(set|reset|clear|write|add|append|insert|remove|delete|destroy|create|load|save|import|export|close|open|copy|"
    "start|stop|pause|handle|execute|launch|call|register|send|announce|acquire|release|move|scale|group|merge)[A-Z]"
)
"""Starts of the names of functions that change something."""

_CALCULATES = {"closePath", "copyMatrix", "copyTable"}
"""They return another value of their argument."""


@pytest.mark.parametrize("space", api.NAMESPACES)
def test_each_function_declares_what_it_does(space: str) -> None:
    assert effects(space).keys() == signatures(space).keys()
    suspicious = {
        name for name, effect in effects(space).items() if effect == "reads" and _CHANGING.match(name)
    }
    assert suspicious <= _CALCULATES


def test_a_function_declares_its_own_effect_or_has_that_of_its_class() -> None:
    class Functions(api.ApiPart, effect="changes"):
        @declarations.reads
        def getSpeed(self) -> int:
            return 1

        @declarations.takes
        @staticmethod
        def getClick() -> int:
            return 2

    assert declarations.declared(Functions.getSpeed) == "reads"
    assert declarations.declared(vars(Functions)["getClick"]) == "takes"
    assert declarations.declared(Functions.__init__) is None
    assert Functions.common_effect == "changes"


def test_functions_that_run_code_of_clients_say_so() -> None:
    of_sim = effects("sim")
    assert {name for name, effect in of_sim.items() if effect == "runs code"} == {
        *("executeScriptString", "setScriptText", "setScriptStringParam", "createScript", "initScript"),
        *("loadPlugin", "loadModule", "launchExecutable"),
    }
    assert of_sim["getUIEventButton"] == of_sim["get2DElementEventButton"] == "takes"
