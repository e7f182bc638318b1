"""What the other packages do and dynmesh does not."""
from __future__ import annotations

from dynmesh.errors import DynmeshError


class Unsupported(DynmeshError, NotImplementedError):
    """A switch, an argument or a method that dynmesh does not have; says what to do instead."""

    reason = "UNSUPPORTED"
