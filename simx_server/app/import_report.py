"""``simx-server FILE.ttt --import-report``: what of a V-REP file arrives here in another form, and what does not.

The file is decoded, converted and compiled as a server does it. A child process starts its scripts, see `rehearsal.py`.
"""

from __future__ import annotations

import json
import logging
import sys

from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_server.errors import CommandError
from simx_server.files.library import DEFAULT_SCENE, find_scene
from simx_server.scene.formats.loader import load_scene
from simx_server.settings.settings import Settings
from simx_server.sim_api.listing.lacking import note_missing

from .rehearsal import rehearse
from .scene_sources import sources_of

logger = logging.getLogger(__name__)


def print_report(settings: Settings, *, as_json: bool) -> int:
    """Print the report on the scene that the settings name. Returns the exit code."""
    try:
        file = find_scene(settings.scene or DEFAULT_SCENE)
        sources = sources_of(settings)
        scene, _ = load_scene(file, sources)
    except CommandError as error:
        logger.error("%s", error)
        return FAILURE
    report = scene.import_report
    if report is None:
        logger.error(
            "'%s' is not a V-REP file, so nothing is imported; give a .ttt or .ttm file before --import-report",
            file,
        )
        return FAILURE
    note_missing(report)
    if report.needs:
        report.rehearsal = rehearse(file, sources, settings.limits)
    text = json.dumps(report.as_record(), indent=1) if as_json else report.as_text()
    sys.stdout.write(text + "\n")
    return DONE
