"""The mesh of an example: in process, or a server's for as long as the example runs."""
from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Optional

import dynmesh


@contextmanager
def opened(server: Optional[str], **options: Any) -> Iterator[dynmesh.Mesh]:
    """A new mesh with the `options` of `dynmesh.open`.

    `server` is the address of a dynmeshd. The mesh is deleted there at the end. Without an address
    the mesh is in this process.
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
