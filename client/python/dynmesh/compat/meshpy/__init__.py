"""The interface of the package `meshpy` on dynmesh: its modules `triangle` and `tet`.

See `dynmesh.compat.meshpy.triangle` and `dynmesh.compat.meshpy.tet`; docs/compat.md has what differs.
"""
