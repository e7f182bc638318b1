"""The interfaces of other packages for meshes, on dynmesh: a program changes one import.

* `dynmesh.compat.triangle`: that of the package `triangle`;
* `dynmesh.compat.meshpy.triangle` and `dynmesh.compat.meshpy.tet`: those of `meshpy`;
* `dynmesh.compat.tetgen`: that of PyVista's `tetgen`.

Names, arguments, switches and arrays are the same. What dynmesh does not do raises `Unsupported`, which
names the switch or the argument. docs/compat.md has what differs.
"""
from __future__ import annotations

from dynmesh.compat._errors import Unsupported

__all__ = ["Unsupported"]
