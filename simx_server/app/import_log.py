"""Log what the import of a V-REP file changed, and the credits in it."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.report import Report

logger = logging.getLogger(__name__)


class ImportLog(Part):
    """Log a line for each imported file, and one for each credit in it."""

    def file_imported(self, report: Report) -> None:
        from simx_server.sim_api.listing.lacking import note_missing  # the whole API, for this file's scripts

        note_missing(report)
        logger.info("%s; --import-report tells more", report.summary())
        for text in report.credits:
            logger.info("'%s' gives credit: %s", report.file, text)
