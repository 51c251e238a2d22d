"""Log what the import of a V-REP file changed, and the credits in it."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from simx_server.simulation.part import Part

from .lacking import note_missing

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.report import Report

logger = logging.getLogger(__name__)


class ImportLog(Part):
    """Log a line for each imported file, and one for each credit in it."""

    def file_imported(self, report: Report) -> None:
        note_missing(report)
        logger.info("%s; --import-report tells more", report.summary())
        for text in report.credits:
            logger.info("'%s' gives credit: %s", report.file, text)
