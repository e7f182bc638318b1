"""What diffs, fields and parts read of their mesh: `Mesh`, which knows all of these."""
from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Any, Optional, Protocol

from dynmesh._types import Array, Label


class MeshState(Protocol):
    """The members of `Mesh` that tell its state."""

    _replica: Any
    _options: Any
    _backend: Any
    _current: Any  #: The diff to the present revision, or None.

    @property
    def dimension(self) -> int: ...

    @property
    def revision(self) -> int: ...

    @property
    def hash(self) -> str: ...

    @property
    def vertex_slots(self) -> int: ...

    @property
    def cell_slots(self) -> int: ...

    @property
    def live_vertices(self) -> Array: ...

    @property
    def live_cells(self) -> Array: ...

    @property
    def region_sets(self) -> dict[int, tuple[int, ...]]: ...

    @property
    def labels(self) -> Mapping[int, Label]: ...

    def features(self, revision: Optional[int] = None) -> list[dict[str, Any]]: ...

    def locked(self) -> AbstractContextManager[Any]: ...
