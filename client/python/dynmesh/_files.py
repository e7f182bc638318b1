"""Features from files, of every format that the `dynmesh` command reads."""
from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, Optional, Union

from dynmesh import _core
from dynmesh._types import Label


@dataclass(frozen=True)
class FileInput:
    """The content of an input file, for a mesh::

        plate = dynmesh.read_input("plate.poly")
        mesh = dynmesh.open(**plate.options)            # or Server.mesh("plate", create=...)
        mesh.apply(**plate.edits)

    Plain data.
    """

    #: Of the mesh: the file's own (an edit script), or the usual ones and the bounding box.
    options: dict[str, Any]
    #: Arguments of `Mesh.apply` and `Mesh.load` that add all features, with their labels.
    edits: dict[str, Any]
    #: A place in each part that is to be left out of the mesh.
    holes: list[tuple[float, ...]]
    #: "file:line" of each feature, by id.
    places: dict[int, str]
    #: What was left out of the file's content.
    warnings: list[str]
    #: Of `read_surface`: "mended"; "thinned", with "triangles_read" and "triangles" (if neither, the
    #: file is as it was read); "found" (what a mesh refuses of it, or ""), "within", "tolerance",
    #: "least_tolerance" (the least one that was allowed, or None), "larger_tolerance" (the next one
    #: that may help, or None), "attempts" (why there was more than one, of `try_mesh`), "farthest" (a bound of how far it
    #: moved, up to a factor of 2), "open_edges_read", "open_edges", "open_loops" (those left, by
    #: ascending length: "points", "length", "middle"), "unfilled" (what a mesh refuses of it with its
    #: holes filled, or ""), "seconds", and "changes", counts by kind.
    preparation: dict[str, Any] = field(default_factory=dict)
    #: Of `read_surface` with `facets`: for each facet of the file, in its order, the id of the
    #: polygon that it is a part of; 0 if there is none within the distance.
    facets: list[int] = field(default_factory=list)


def _edits_of(features: list[dict[str, Any]]) -> dict[str, Any]:
    edits: dict[str, Any] = {"add_points": {}, "add_segments": {}, "add_polygons": {},
                             "add_sizes": {}, "set_labels": {}, "unsplit": []}
    for feature in features:
        id_, kind = feature.pop("id"), feature.pop("kind")
        marker, name = feature.pop("marker", 0), feature.pop("name", "")
        if feature.pop("unsplit", False):
            edits["unsplit"].append(id_)
        if marker or name:
            edits["set_labels"][id_] = Label(marker, name)
        # The others have one member: a position, ends or rings.
        edits[f"add_{kind}s"][id_] = feature if kind == "size" else next(iter(feature.values()))
    return {name: value for name, value in edits.items() if value}


def read_input(path: Union[str, os.PathLike[str]], *, merge_coplanar: bool = False,
               polygons: bool = False, refine: bool = False,
               keep_facets: bool = False) -> FileInput:
    """The features in a file; its extension says which format it has.

    Raises `InvalidArgument` with file and line for bad content, and with the formats that there are
    for an unknown extension; `NotFound` if there is no such file.

    Args:
        path: .node, .poly, .smesh, .off, .stl, .obj, .ply, .msh, .mesh, .vtu, .geojson, .topojson,
            .json or .dynmesh.
        merge_coplanar: faces of 3D input that lie in one plane and have one marker are joined.
        polygons: rings of a map are polygons, not segments.
        refine: the file is a mesh to be refined: all its vertices are points.
        keep_facets: of .off, .stl, .obj and .ply: faces in one plane stay as they are. Otherwise those
            that are in one plane within the rounding of the file's numbers become one polygon, whose
            corners move onto the plane, by 4 roundings at most.
    """
    read = _core.read_input(os.fspath(path), merge_coplanar, polygons, refine,
                            keep_facets)
    return FileInput(read["options"], _edits_of(read["features"]), read["holes"], read["places"],
                     read["warnings"])


def read_surface(path: Union[str, os.PathLike[str]], *, within: Optional[float] = None,
                 fill_holes: Optional[float] = None, mending_tolerance: Optional[float] = None,
                 polygons: bool = True, keep_facets: bool = False,
                 facets: bool = False, try_mesh: bool = False) -> FileInput:
    """The features in a surface file or a map, mended where a mesh refuses them.

    The same as the command `dynmesh mesh` does. What crosses, overlaps, nearly touches or is there
    twice is mended, with the least tolerance that does, and cracks between open edges of a surface
    are closed. If nothing within the distance helps, it is as it was read: a mesh refuses it. Faces
    of a surface that are finer than the distance needs become fewer.

    Some surfaces are accepted, and take too many vertices all the same. `dynmesh mesh` tries these
    with a larger tolerance, and so does `try_mesh`, which makes a mesh without a trace to find that
    out, and drops it. A program that gets `LimitExceeded` for one may do so by
    `mending_tolerance=read.preparation["larger_tolerance"]`, as long as that is not None.

    Raises `InvalidArgument` with file and line for bad content, and if nothing is left; with
    `try_mesh` also what a mesh refuses, `LimitExceeded` if it would have more than 2,000,000
    vertices, or 500 for each feature.

    Args:
        path: as of `read_input`. Surfaces, maps, and 2D .poly and .node are prepared; others if
            `within` or `fill_holes` is given.
        within: how far an edge or a face may move, to both sides; None: 1e-4 of the diagonal of the
            input's box.
        fill_holes: of 3D: holes, loops of edges with one face, are filled up to this length. Flat
            ones become a polygon, others triangles of their corners.
        mending_tolerance: of surfaces: mending has this tolerance or a larger one, even if a mesh
            accepts the surface as it is.
        polygons: rings of a map are polygons, not segments.
        keep_facets: as of `read_input`.
        facets: tell which polygon each facet of a surface file is a part of.
        try_mesh: with a larger tolerance where a mesh of the surface is too fine.
    """
    read = _core.read_surface(os.fspath(path), within, fill_holes, mending_tolerance, polygons,
                              keep_facets, facets, try_mesh)
    return FileInput(read["options"], _edits_of(read["features"]), read["holes"], read["places"],
                     read["warnings"], read["preparation"], read["facets"])
