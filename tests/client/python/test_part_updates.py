"""Parts that follow random edits are those made anew, opened ones included.

DYNMESH_PART_EDITS: how many edits, 2,000 or 10,000 for a long test.
"""
import os

import numpy as np
import pytest

import dynmesh

EDITS = int(os.environ.get("DYNMESH_PART_EDITS", 0))


def identities(part):
    """Of each vertex its slot and the least slot of its cells: copies differ in that."""
    least = np.full(len(part.vertex_slots), np.iinfo(np.int64).max)
    np.minimum.at(least, part.cells, part.cell_slots[:, None].astype(np.int64))
    return np.column_stack([part.vertex_slots, least])


def in_order(rows):
    return np.lexsort(rows.T[::-1])


def content(part):
    """All that a part has, in an order that does not depend on its numbers."""
    identity = identities(part)
    cells = np.argsort(part.cell_slots)
    vertices = in_order(identity)
    # Facets by their cells and corners; the twins as rows of the same. Within the part either cell
    # may be the first.
    corners = np.take_along_axis(part.facets, np.argsort(part.vertex_slots[part.facets], axis=1), 1)
    corners = identity[corners].reshape(len(part.facets), -1)
    beside = part._part.facet_cells  # slots
    beside = np.where(beside[:, 1:] >= 0, np.sort(beside, axis=1), beside)
    facets = np.column_stack([corners, beside, part.facet_owners.astype(np.int64),
                              part.facet_markers, part.facet_sides])
    twins = np.where((part.facet_twins >= 0)[:, None], facets[part.facet_twins], -1)
    order = in_order(facets)
    return {"cells": np.column_stack([part.cell_slots, identity[part.cells].reshape(len(cells), -1)])[cells],
            "regions": part.cell_regions[cells], "vertices": identity[vertices],
            "points": part.points[vertices], "origin": part.vertex_slots[part.origin][vertices],
            "facets": facets[order], "twins": twins[order], "names": part.facet_names[order]}


def check_numbers(part):
    """Numbers and slots lead to each other; a vertex has one first copy."""
    n = len(part.vertex_slots)
    first = np.flatnonzero(part.origin == np.arange(n))
    np.testing.assert_array_equal(part.vertex_numbers[part.vertex_slots[first]], first)
    assert len(np.unique(part.vertex_slots)) == len(first)
    np.testing.assert_array_equal(part.vertex_slots[part.origin], part.vertex_slots)
    assert (part.vertex_numbers >= 0).sum() == len(first)
    np.testing.assert_array_equal(part.cell_numbers[part.cell_slots], np.arange(len(part.cell_slots)))
    assert (part.cell_numbers >= 0).sum() == len(part.cell_slots)
    np.testing.assert_array_equal(part.mesh.points[part.vertex_slots], part.points)
    # The first cell of a facet is on its left, in 3D below it.
    corners = part.points[part.facets]
    apex = part.points[part.cells[part.facet_cells[:, 0]]].mean(axis=1)
    side = np.linalg.det(np.concatenate([corners[:, 1:], apex[:, None]], axis=1) - corners[:, :1])
    assert (side > 0 if part.mesh.dimension == 2 else side < 0).all()


class Scene:
    """Random edits of points and cracks in a domain, polygon 7 or what encloses the unit cube."""

    def __init__(self, dimension, random):
        self.random, self.dimension = random, dimension
        self.next, self.points, self.cracks = 1000, [], []
        if dimension == 2:
            self.mesh = dynmesh.open(box=[[0, 0], [1, 1]], max_edge=0.2)
            self.mesh.apply(add_points={1: (0, 0), 2: (1, 0), 3: (1, 0.5), 4: (1, 1), 5: (0, 1),
                                        21: (0.3, 0.5)},
                            add_polygons={7: (1, 2, 3, 4, 5)}, add_segments={30: (21, 3)},
                            set_labels={30: dict(name="crack"), 7: dict(marker=3, name="plate")})
        else:
            self.mesh = dynmesh.open(box=[[0] * 3, [1] * 3])
            corners = {1 + 4 * level + i: (x, y, z) for level, z in enumerate((0, 0.5, 1))
                       for i, (x, y) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1)))}
            walls = {40 + 4 * level + i: (a, 4 * level + 1 + (i + 1) % 4,
                                          4 * level + 5 + (i + 1) % 4, a + 4)
                     for level in range(2) for i, a in enumerate(range(4 * level + 1, 4 * level + 5))}
            self.mesh.apply(add_points=corners,
                            add_polygons={30: (5, 6, 7, 8), 31: (1, 2, 3, 4), 32: (9, 10, 11, 12),
                                          **walls},
                            set_labels={30: dict(name="crack")})
        self.choices = [dict(), dict(open=["crack"]), dict(open=[30])]
        self.parts = [self.mesh.part(**choice) for choice in self.choices]

    def place(self):
        return self.random.random(self.dimension) * 1.04 - 0.02

    def crack(self):
        """A small segment, or triangle, of new points."""
        centre = self.random.uniform(0.1, 0.9, self.dimension)
        ends = [self.next + i for i in range(self.dimension)]
        self.next += self.dimension + 1
        id_ = self.next - 1
        batch = dict(add_points={end: centre + self.random.uniform(-0.15, 0.15, self.dimension)
                                 for end in ends})
        batch["add_segments" if self.dimension == 2 else "add_polygons"] = {id_: ends}
        if self.random.random() < 0.7:
            batch["set_labels"] = {id_: dict(name="crack", marker=int(self.random.integers(1, 5)))}
        return batch, (id_, ends)

    def edit(self):
        """One random edit; False if the mesh refused it."""
        kind = self.random.integers(8)
        random, mesh = self.random, self.mesh
        came, crack, gone, lost = [], None, None, None
        if kind <= 1 or not self.points:
            came = [self.next + i for i in range(int(random.integers(1, 4)))]
            self.next += len(came)
            batch = dict(add_points={id_: self.place() for id_ in came})
        elif kind == 2:
            gone = self.points[random.integers(len(self.points))]
            batch = dict(remove=[gone])
        elif kind == 3:
            batch = dict(move_points={self.points[random.integers(len(self.points))]: self.place()})
        elif kind == 4 or not self.cracks:
            batch, crack = self.crack()
        elif kind == 5:
            lost = self.cracks[random.integers(len(self.cracks))]
            batch = dict(remove=[lost[0], *lost[1]])
        elif kind == 6:
            id_, ends = self.cracks[random.integers(len(self.cracks))]
            at = {f["id"]: np.array(f["at"]) for f in mesh.features() if f["id"] in ends}
            batch = dict(move_points={end: at[end] + random.normal(0, 0.03, self.dimension)
                                      for end in ends[:int(random.integers(1, 3))]})
        else:
            id_ = self.cracks[random.integers(len(self.cracks))][0]
            batch = dict(set_labels={id_: dict(name=str(random.choice(["crack", "wall", ""])), marker=2)})
        if len(self.points) > 12 and kind <= 1:
            return False
        if len(self.cracks) > 4 and crack:
            return False
        try:
            diff = mesh.apply(**batch)
        except dynmesh.DynmeshError:
            return False
        self.points += came
        if gone:
            self.points.remove(gone)
        if crack:
            self.cracks.append(crack)
        if lost:
            self.cracks.remove(lost)
        for part in self.parts:
            part.update(diff)
        return True


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_part_that_follows_is_the_part_made_anew(dimension, random):
    scene = Scene(dimension, random)
    edits, opened, wanted = 0, 0, EDITS or (150 if dimension == 2 else 30)
    while edits < wanted:
        if not scene.edit():
            continue
        edits += 1
        for part, choice in zip(scene.parts, scene.choices):
            check_numbers(part)
            followed, anew = content(part), content(scene.mesh.part(**choice))
            for key, rows in anew.items():
                np.testing.assert_array_equal(followed[key], rows, err_msg=f"{key} after {edits}: "
                                              f"{choice}")
        opened += len(np.unique(scene.parts[1].vertex_slots)) < len(scene.parts[1].vertex_slots)
    assert opened > wanted / 10


def test_arrays_get_shorter_when_their_last_rows_go():
    """A crack with one vertex between its tips is closed by its name: no other row changes."""
    mesh = dynmesh.open(box=[[0, 0], [1, 1]])
    mesh.apply(add_points={1: (0, 0), 2: (1, 0), 3: (1, 1), 4: (0, 1), 11: (0.4, 0.5),
                           12: (0.5, 0.5), 13: (0.6, 0.5)},
               add_polygons={7: (1, 2, 3, 4)}, add_segments={20: (11, 12), 21: (12, 13)},
               set_labels={20: dict(name="crack"), 21: dict(name="crack")})
    part = mesh.part(open="crack")
    opened = len(part.points), len(part.origin), len(part.facets), len(part.vertex_slots)
    part.update(mesh.apply(set_labels={20: dict(name="seam"), 21: dict(name="seam")}))
    closed = len(part.points), len(part.origin), len(part.facets), len(part.vertex_slots)
    anew = mesh.part()
    assert closed == (len(anew.points), len(anew.origin), len(anew.facets), len(anew.vertex_slots))
    assert closed[0] == opened[0] - 1
