"""The mesh of an example: in process, or at a server while the example runs."""
from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Optional

import dynmesh


@contextmanager
def opened(server: Optional[str], **options: Any) -> Iterator[dynmesh.Mesh]:
    """A new mesh with the `options` of `dynmesh.open`.

    `server` is the address of a dynmeshd, where the mesh is deleted at the end. If it is empty, the
    mesh is in this process.
    """
    if server is None:
        yield dynmesh.open(**options)
        return
    with dynmesh.connect(server) as connection:
        mesh = connection.create(**options)
        try:
            yield mesh
        finally:
            connection.delete(mesh.name)
