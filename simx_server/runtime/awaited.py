"""Find the calls of a batch that a client waits for."""

from __future__ import annotations

from simx_client.protocol.codec import CodecError, decode_batch, encode
from simx_client.protocol.messages import NOT_AWAITED_MS, Batch, Call, Operation


def divide(payload: bytes) -> tuple[bytes | None, bytes | None]:
    """Return the calls of a batch that its client waits for, and the others, each encoded; None if there are none.

    An unreadable batch counts as one without awaited calls.
    """
    try:
        batch = decode_batch(payload)
    except CodecError:
        return None, payload
    awaited = [call for call in batch.calls if _is_awaited(call)]
    if not awaited:
        return None, payload
    others = [call for call in batch.calls if not _is_awaited(call)]
    return _with(batch, awaited), _with(batch, others) if others else None


def _is_awaited(call: Call) -> bool:
    return call.operation == Operation.EXECUTE and call.delay_ms < NOT_AWAITED_MS


def _with(batch: Batch, calls: list[Call]) -> bytes:
    return encode(Batch(batch.message_id, batch.client_time, calls))
