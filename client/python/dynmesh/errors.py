"""Errors as exceptions: each has the reason, the features and the edit to blame."""
from __future__ import annotations

from typing import Optional, Sequence


class DynmeshError(Exception):
    """An error of the library or the server."""

    #: The status code, such as "INVALID_ARGUMENT".
    code: str = "UNKNOWN"
    #: The machine-readable reason, such as "SEGMENTS_CROSS"; "" if there is none. Reasons are
    #: defined in `dynmesh/error.h` and `dynmesh/codec/service_error.h`.
    reason: str = ""
    #: Ids of the features involved, the offender first.
    features: Sequence[int] = ()
    #: Index in the batch of the edit to blame, if any.
    edit: Optional[int] = None
    #: Path of the request's field to blame, if any.
    field: str = ""
    #: Seconds after which to retry, if the server sent them.
    retry_after: Optional[float] = None


class InvalidArgument(DynmeshError, ValueError):
    """The input is invalid for any mesh; nothing has changed."""


class FailedPrecondition(DynmeshError):
    """The input is invalid for the mesh's present state; nothing has changed."""


class Conflict(FailedPrecondition):
    """The mesh is not at the expected revision; nothing has changed."""


class NotFound(DynmeshError, LookupError):
    """There is no such mesh or feature."""


class AlreadyExists(DynmeshError):
    """A mesh or feature with that name or id exists already."""


class OutOfRange(DynmeshError):
    """The server does not have this revision, or no longer has it."""


class LimitExceeded(DynmeshError):
    """A limit of the mesh or the server is exceeded; nothing has changed."""


class Unavailable(DynmeshError, ConnectionError):
    """The server cannot be reached, is starting or is shutting down. Retrying may help."""


class VersionMismatch(DynmeshError):
    """The server has another version than this package; no call was made."""


class DeadlineExceeded(DynmeshError, TimeoutError):
    """The call took longer than the timeout."""


class PermissionDenied(DynmeshError, PermissionError):
    """The token is missing, unknown or lacks the role."""


class DataLoss(DynmeshError):
    """Mesh and diff do not fit together: `Mesh.sync` fetches the mesh again."""


class Cancelled(DynmeshError):
    """The call was cancelled; nothing has changed."""


class StaleDiff(DynmeshError, ValueError):
    """The mesh has a later revision: transfer fields before the next edit is applied."""


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
    """The exception for a status; called by the extension module."""
    error = _CLASSES.get(code, DynmeshError)(f"{reason}: {message}" if reason else message)
    error.code = code
    error.reason = reason
    error.features = list(features)
    error.edit = edit
    error.field = field
    error.retry_after = retry_after
    return error
