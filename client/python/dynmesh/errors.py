"""What can go wrong, as exceptions: each has the reason, the features and the edit to blame."""
from __future__ import annotations

from typing import Optional, Sequence


class DynmeshError(Exception):
    """An error of the library or the server."""

    #: The status code, such as "INVALID_ARGUMENT".
    code: str = "UNKNOWN"
    #: The machine-readable reason, such as "SEGMENTS_CROSS"; "" if there is none. They are those of
    #: `dynmesh/error.h` and `dynmesh/codec/service_error.h`.
    reason: str = ""
    #: Ids of the features involved, the offender first.
    features: Sequence[int] = ()
    #: Index in the batch of the edit to blame, if one is.
    edit: Optional[int] = None
    #: Path of the field of the request to blame, if one is.
    field: str = ""
    #: Seconds after which to try again, if the server says so.
    retry_after: Optional[float] = None


class InvalidArgument(DynmeshError, ValueError):
    """The input cannot be what is meant; nothing has changed."""


class FailedPrecondition(DynmeshError):
    """The input does not fit the state of the mesh; nothing has changed."""


class Conflict(FailedPrecondition):
    """The mesh is not at the expected revision; nothing has changed."""


class NotFound(DynmeshError, LookupError):
    """There is no such mesh or feature."""


class AlreadyExists(DynmeshError):
    """There is one already."""


class OutOfRange(DynmeshError):
    """A revision that the server does not have, or not any more."""


class LimitExceeded(DynmeshError):
    """A limit of the mesh or the server; nothing has changed."""


class Unavailable(DynmeshError, ConnectionError):
    """The server cannot be reached, starts or ends. Trying again may help."""


class VersionMismatch(DynmeshError):
    """The server is of another version than this package; nothing was asked of it."""


class DeadlineExceeded(DynmeshError, TimeoutError):
    """The call took longer than the timeout."""


class PermissionDenied(DynmeshError, PermissionError):
    """The token is missing, unknown or of a lesser role."""


class DataLoss(DynmeshError):
    """Mesh and diff do not fit together: `Mesh.sync` takes the mesh anew."""


class Cancelled(DynmeshError):
    """The call was cancelled; nothing has changed."""


class StaleDiff(DynmeshError, ValueError):
    """The mesh has gone on: fields are carried before the next edit is applied."""


_CLASSES: dict[str, type[DynmeshError]] = {
    "INVALID_ARGUMENT": InvalidArgument,
    "FAILED_PRECONDITION": FailedPrecondition,
    "ABORTED": Conflict,
    "NOT_FOUND": NotFound,
    "ALREADY_EXISTS": AlreadyExists,
    "OUT_OF_RANGE": OutOfRange,
    "RESOURCE_EXHAUSTED": LimitExceeded,
    "UNAVAILABLE": Unavailable,
    "DEADLINE_EXCEEDED": DeadlineExceeded,
    "PERMISSION_DENIED": PermissionDenied,
    "UNAUTHENTICATED": PermissionDenied,
    "DATA_LOSS": DataLoss,
    "CANCELLED": Cancelled,
}


def make(
    code: str,
    message: str,
    reason: str,
    features: Sequence[int],
    edit: Optional[int],
    field: str,
    retry_after: Optional[float],
) -> DynmeshError:
    """The exception of a status; called by the extension module."""
    error = _CLASSES.get(code, DynmeshError)(f"{reason}: {message}" if reason else message)
    error.code = code
    error.reason = reason
    error.features = list(features)
    error.edit = edit
    error.field = field
    error.retry_after = retry_after
    return error
