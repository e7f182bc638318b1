"""The interface of PyVista's package `tetgen` on dynmesh::

    from dynmesh.compat import tetgen                   # was: import tetgen
    tet = tetgen.TetGen(vertices, faces)                # or a surface of PyVista
    nodes, elements = tet.tetrahedralize(order=1, mindihedral=10, minratio=1.5)

docs/compat.md has what is the same and what differs.
"""
from __future__ import annotations

import os
from typing import Any, Optional

import numpy as np

from dynmesh._files import read_surface
from dynmesh._types import Array
from dynmesh.compat import _solid
from dynmesh.compat._domain import array_of, indices_of
from dynmesh.compat._errors import Unsupported

__all__ = ["TetGen"]

# Arguments of `tetrahedralize` that have no effect on what a mesh promises.
_WITHOUT_EFFECT = frozenset((
    "brio_hilbert", "brio_threshold", "brio_ratio", "hilbert_order", "hilbert_limit", "flipinsert",
    "noexact", "nostaticfilter", "zeroindex", "facesout", "edgesout", "neighout", "meditview", "vtksurfview",
    "vtkview", "geomview", "nobound", "nonodewritten", "noelewritten", "nofacewritten", "noiterationnum",
    "nojettison", "docheck", "quiet", "verbose", "vertexperblock", "tetrahedraperblock",
    "shellfaceperblock", "supsteiner_level", "addsteiner_algo", "optlevel", "optpasses", "optscheme",
    "opt_max_flip_level", "opt_iterations", "opt_max_asp_ratio", "optmaxdihedral", "optminsmtdihed",
    "optminslidihed", "epsilon", "facet_separate_ang_tol", "facet_overlap_ang_tol",
    "facet_small_ang_tol", "reversetetori", "nomergevertex", "elem_growth_ratio", "flip_star_size",
    "flipstarsize", "fliplinklevel", "fliplinklevelinc", "reflevel", "cdtrefine", "collinear_ang_tol",
    "refine_progress_ratio", "coarsen_percent", "toltol"))
_REFUSED = {
    "psc": "the surface is what its facets are", "refine": _solid._REFUSED["r"],
    "nobisect": _solid._REFUSED["Y"], "cdt": "there is no triangulation without new vertices",
    "coarsen": _solid._REFUSED["R"], "weighted": _solid._REFUSED["w"], "metric": _solid._REFUSED["m"],
    "insertaddpoints": "add the points to the surface's vertices", "diagnose": _solid._REFUSED["d"],
    "convex": _solid._REFUSED["c"], "voroout": _solid._REFUSED["v"],
    "bgmeshfilename": "no background mesh: a mesh of dynmesh.open has add_sizes",
    "bgmesh_v": "no background mesh", "bgmesh_tet": "no background mesh", "bgmesh_mtr": "no background mesh",
}


class TetGen:
    """Makes tetrahedra inside a closed surface.

    Args:
        args: `(vertices, faces)`, or with a number for each face as a third: arrays (n, 3) and (m, 3), or
            lists of polygons. Or a surface of PyVista: what has `points` and `faces`. Or the name of a file
            that `dynmesh.read_surface` reads, which mends it.
    """

    def __init__(self, *args: Any) -> None:
        #: The surface that was given, if it was one.
        self.mesh: Any = None
        markers: Any = None
        if len(args) == 1 and isinstance(args[0], (str, os.PathLike)):
            read = read_surface(args[0]).edits
            numbers = {id_: i for i, id_ in enumerate(read["add_points"])}
            points: Any = list(read["add_points"].values())
            rings: Any = [[[numbers[id_] for id_ in ring] for ring in polygon]
                          for polygon in read.get("add_polygons", {}).values()]
        elif len(args) == 1 and hasattr(args[0], "points") and hasattr(args[0], "faces"):
            self.mesh = args[0]
            points, rings = np.asarray(args[0].points), _faces_of(args[0].faces)
        elif len(args) in (2, 3):
            points, rings = args[0], [[list(face)] for face in args[1]]
            markers = args[2] if len(args) == 3 else None
        else:
            raise TypeError("TetGen takes vertices and faces, a surface with points and faces, or the name "
                            f"of a file, and got {', '.join(type(a).__name__ for a in args) or 'nothing'}")
        #: Coordinates of the surface's vertices: (n, 3).
        self.v: Array = array_of(points, "vertices", 3)
        self._rings = [[[int(i) for i in ring] for ring in polygon] for polygon in rings]
        for number, polygon in enumerate(self._rings):
            if min(map(len, polygon)) < 3:
                raise ValueError(f"faces: face {number} has fewer than three vertices")
            indices_of([ring[:2] for ring in polygon] + [ring[-2:] for ring in polygon], "faces", 2,
                       len(self.v))
        is_triangular = all(len(polygon) == 1 and len(polygon[0]) == 3 for polygon in self._rings)
        #: Corners of the surface's triangles, (m, 3); None if it has other polygons.
        self.f: Optional[Array] = (np.array([p[0] for p in self._rings], np.int32).reshape(-1, 3)
                                   if is_triangular else None)
        self._markers: Optional[Array] = None
        if markers is not None:
            self._markers = np.asarray(markers, np.int32).reshape(-1)
            if len(self._markers) != len(self._rings):
                raise ValueError(f"face markers: {len(self._rings)} numbers, and got {len(self._markers)}")
        #: The mesh's vertices, (n, 3), those of the surface first; None before `tetrahedralize`.
        self.node: Optional[Array] = None
        #: Corners of tetrahedra, (m, 4) or, with `order=2`, (m, 10), int32.
        self.elem: Optional[Array] = None
        #: With `regionattrib` the region of each tetrahedron, (m, 1).
        self.attributes: Optional[Array] = None
        #: The mesh's triangles on the surface: (k, 3), int32.
        self.trifaces: Optional[Array] = None
        #: A number for each of `trifaces`: that of its face; 1 if faces have none.
        self.triface_markers: Optional[Array] = None
        self._regions: dict[int, tuple[Any, float]] = {}
        self._holes: list[Any] = []

    def add_region(self, id: int, point_in_region: Any, max_vol: float = 0.0) -> None:  # noqa: A002
        """A region has a number, and may have a largest volume.

        Args:
            id: the number, in `attributes`.
            point_in_region: a place in the region.
            max_vol: the largest volume of a tetrahedron there; 0: none.
        """
        self._regions[id] = (array_of([point_in_region], "point_in_region", 3)[0], float(max_vol))

    def add_hole(self, point: Any) -> None:
        """What is around a place, up to faces, is left out.

        Args:
            point: the place.
        """
        self._holes.append(array_of([point], "point", 3)[0])

    def make_manifold(self, verbose: bool = False) -> None:
        """Raises `Unsupported`: `dynmesh.read_surface` mends surfaces as it reads them.

        Args:
            verbose: has no effect.
        """
        raise Unsupported("make_manifold: a surface is mended as it is read: TetGen('part.stl'), or "
                          "dynmesh.read_surface('part.stl', fill_holes=...)")

    def tetrahedralize(self, plc: bool = True, quality: bool = True, *, order: int = 1,
                       minratio: float = 2.0, mindihedral: float = 0.0, maxvolume: float = -1.0,
                       fixedvolume: bool = False, varvolume: bool = False, regionattrib: bool = False,
                       nomergefacet: bool = False, steinerleft: int = -1, switches: str = "",
                       **other: Any) -> Any:
        """Makes the tetrahedra.

        Args:
            plc: with facets; False is `Unsupported`.
            quality: with bounds of quality; False is `Unsupported`.
            order: 2 for tetrahedra of ten nodes, in the order of VTK.
            minratio: the largest circumradius / shortest edge, from 1.4.
            mindihedral: the least dihedral angle, to 20 degrees; below 10 it is 10. Some slivers may stay.
            maxvolume: the largest volume; not above 0: none.
            fixedvolume: has no effect: `maxvolume` counts.
            varvolume: volumes of regions count; they do without it, too.
            regionattrib: `attributes` tell regions.
            nomergefacet: faces in one plane are not joined.
            steinerleft: if not below 0, an error if more new vertices are needed.
            switches: TetGen's, as "pq1.5/10a0.1"; they replace all of the arguments above.
            other: further arguments of the package. Those of speed, printing and tolerances have no effect;
                others raise `Unsupported`, if they are true.

        Returns:
            `node` and `elem`; with `regionattrib` also `attributes`.

        Raises:
            Unsupported: what dynmesh does not have, by name.
            FailedPrecondition, InvalidArgument: a surface that a mesh refuses, as one that crosses itself.
            ValueError: the surface is open: nothing is left of the mesh.
        """
        for name, value in other.items():
            if name in _REFUSED:
                if value:
                    raise Unsupported(f"{name}: {_REFUSED[name]}")
            elif name not in _WITHOUT_EFFECT:
                raise TypeError(f"tetrahedralize has no argument {name!r}")
        wanted = _solid.SolidSwitches(
            plc, minratio if quality else None, mindihedral, maxvolume if maxvolume > 0 else None, True,
            regionattrib, not nomergefacet, None if steinerleft < 0 else int(steinerleft), order)
        if switches:
            wanted = _solid.parse(switches)
            if wanted.adds_points:
                raise Unsupported(f"the switch i: {_REFUSED['insertaddpoints']}")
        if wanted.order not in (1, 2):
            raise ValueError(f"order: 1 or 2, and got {order!r}")
        if not wanted.has_facets or wanted.ratio is None:
            raise Unsupported("plc, quality: tetrahedra without facets, or without a bound of quality, are not "
                              "there: leave both True, or use the switches pq")
        regions = np.array([[*place, id_, volume] for id_, (place, volume) in self._regions.items()],
                           np.float64).reshape(-1, 5)
        solid = _solid.Solid(_solid.Body(
            self.v, self._rings, self._markers, np.array(self._holes, np.float64).reshape(-1, 3), regions,
            ratio=wanted.ratio, angle=wanted.angle or 0.0, volume=wanted.volume,
            has_region_volumes=wanted.has_volumes, merges=wanted.merges, most_new=wanted.most_new))
        cut = solid.cut
        self.node, self.elem = cut.points, cut.cells
        if wanted.order == 2:
            self.node, self.elem = _solid.with_middles(self.node, self.elem,
                                                         _solid.ORDER_OF_VTK)
        self.trifaces, self.triface_markers = cut.facets, solid.facet_markers()
        self.attributes = solid.attributes().reshape(-1, 1) if wanted.attributes else None
        if self.attributes is not None:
            return self.node, self.elem, self.attributes
        return self.node, self.elem

    @property
    def grid(self) -> Any:
        """The mesh as a `pyvista.UnstructuredGrid`. Raises ImportError without PyVista."""
        if self.node is None or self.elem is None:
            raise RuntimeError("there is no mesh yet: call tetrahedralize() first")
        import pyvista

        width = self.elem.shape[1]
        cells = np.concatenate([np.full((len(self.elem), 1), width, np.int32), self.elem], axis=1)
        kinds = np.full(len(self.elem), 10 if width == 4 else 24, np.uint8)
        return pyvista.UnstructuredGrid(cells.reshape(-1), kinds, self.node)

    def plot(self, **kwargs: Any) -> Any:
        """Shows the mesh by PyVista.

        Args:
            kwargs: those of `pyvista.UnstructuredGrid.plot`.
        """
        return self.grid.plot(**kwargs)

    def write(self, filename: str, binary: bool = False) -> None:
        """Writes the tetrahedra as a legacy .vtk file, text.

        Args:
            filename: the file; an old one is replaced.
            binary: `Unsupported`.
        """
        if binary:
            raise Unsupported("binary: a .vtk is written as text; grid.save(filename) writes others")
        if self.node is None or self.elem is None:
            raise RuntimeError("there is no mesh yet: call tetrahedralize() first")
        _solid.write_vtk(filename, self.node, self.elem)


def _faces_of(faces: Any) -> list[list[list[int]]]:
    """Polygons from the flat array of PyVista, of a number of corners before each of them."""
    flat = np.asarray(faces).reshape(-1)
    if len(flat) and len(flat) % 4 == 0 and (flat[::4] == 3).all():
        return [[ring] for ring in flat.reshape(-1, 4)[:, 1:].tolist()]
    result = []
    at = 0
    while at < len(flat):
        count = int(flat[at])
        if count < 3 or at + count >= len(flat):
            raise ValueError("faces: PyVista's array has the number of corners before those of each face")
        result.append([flat[at + 1:at + 1 + count].tolist()])
        at += count + 1
    return result
