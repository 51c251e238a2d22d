"""Format log lines on stderr: sentences for people, or one JSON object per line for log collectors."""

from __future__ import annotations

import json
import logging
import sys
import threading
from datetime import UTC, datetime
from types import TracebackType

from simx_client.protocol.cli.terminal import Paint

TEXT, JSON = FORMATS = ("text", "json")

logger = logging.getLogger(__name__)


_COLOURS = {"DEBUG": "grey", "INFO": "green", "WARNING": "yellow", "ERROR": "red", "CRITICAL": "red"}


class TextFormatter(logging.Formatter):
    """Write a line of text for each record, its level in colour where the stream shows colours."""

    def __init__(self, paint: Paint, *, several: bool) -> None:
        process = " [%(process)d]" if several else ""
        super().__init__(f"%(asctime)s %(levelname)s{process} %(name)s: %(message)s", "%H:%M:%S")
        self._paint = paint

    def formatMessage(self, record: logging.LogRecord) -> str:
        level = record.levelname
        painted = self._paint(level, _COLOURS.get(level, "bold"))
        # A copy: other handlers of the record write the plain level.
        return super().formatMessage(logging.makeLogRecord({**vars(record), "levelname": painted}))


class JsonFormatter(logging.Formatter):
    """Write one line of ASCII for each record: time (ISO 8601, UTC), level, logger, message, process, and exception."""

    def format(self, record: logging.LogRecord) -> str:
        line: dict[str, object] = {
            "time": datetime.fromtimestamp(record.created, UTC).strftime("%Y-%m-%dT%H:%M:%S.%fZ"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "process": record.process,
        }
        if record.exc_info:
            line["exception"] = self.formatException(record.exc_info)
        if record.stack_info:
            line["stack"] = self.formatStack(record.stack_info)
        return json.dumps(line)


def configure(level: str, form: str, *, several: bool) -> None:
    """Log to stderr; of other packages only warnings.

    Args:
        form: one of FORMATS; with JSON, Python's own output there, warnings and uncaught exceptions, becomes a line as
            well.
        several: this process is one of many, so lines of text name it; those of JSON always do.
    """
    handler = logging.StreamHandler(sys.stderr)
    if form == JSON:
        handler.setFormatter(JsonFormatter())
        logging.captureWarnings(True)
        sys.excepthook = _log_uncaught
        threading.excepthook = _log_uncaught_in_thread
    else:
        handler.setFormatter(TextFormatter(Paint(sys.stderr), several=several))
    logging.basicConfig(handlers=[handler], level=logging.WARNING)
    for package in ("simx_server", "simx_client"):
        logging.getLogger(package).setLevel(level.upper())


def _log_uncaught(kind: type[BaseException], error: BaseException, traceback: TracebackType | None) -> None:
    logger.critical("the program ends by an error", exc_info=(kind, error, traceback))


def _log_uncaught_in_thread(arguments: threading.ExceptHookArgs) -> None:
    name = arguments.thread.name if arguments.thread else "that is unknown"
    error = arguments.exc_value or arguments.exc_type()
    logger.critical(
        "thread %s ends by an error", name, exc_info=(arguments.exc_type, error, arguments.exc_traceback)
    )
