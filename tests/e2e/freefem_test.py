#!/usr/bin/env python3
"""Poisson's equation in FreeFEM, on meshes that `dynmesh mesh` wrote as .mesh.

    freefem_test.py DYNMESH

Markers of the input are FreeFEM's labels, attributes of regions its regions. Linear elements: at
half the edge length the error is a quarter. Ends with 77, and says so, if FreeFEM is not installed.
"""
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77

# A square of side 2 with a square hole; sides 1 to 4, the hole's 5; region 7.
SQUARE = """8 2 0 0
1 0 0
2 2 0
3 2 2
4 0 2
5 .8 .8
6 1.2 .8
7 1.2 1.2
8 .8 1.2
8 1
1 1 2 1
2 2 3 2
3 3 4 3
4 4 1 4
5 5 6 5
6 6 7 5
7 7 8 5
8 8 5 5
1
1 1 1
1
1 .1 .1 7
"""


def cube(side, begin, markers):
    """The corners and facets of a cube around (1, 1, 1)."""
    lo, hi = 1 - side / 2, 1 + side / 2
    corners = [(x, y, z) for z in (lo, hi) for x, y in ((lo, lo), (hi, lo), (hi, hi), (lo, hi))]
    nodes = [f"{begin + i} {x} {y} {z}" for i, (x, y, z) in enumerate(corners)]
    rings = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    facets = [f"4 {' '.join(str(begin + i) for i in ring)} {marker}"
              for ring, marker in zip(rings, markers)]
    return nodes, facets


def cubes():
    """A cube of side 2, sides 1 to 6, around one of side 1, label 9; regions 3 and 4."""
    nodes, facets = [], []
    for part in (cube(2, 1, range(1, 7)), cube(1, 9, [9] * 6)):
        nodes += part[0]
        facets += part[1]
    return "\n".join(["16 3 0 0", *nodes, "12 1", *facets, "0",
                      "2", "1 .1 .1 .1 3", "2 1 1 1 4", ""])


# The solution is known; the prints are checked below.
PLANE = """
mesh Th = readmesh("m.mesh");
fespace Vh(Th, P1);
Vh u, v;
func exact = sin(pi * x / 2) * sin(pi * y / 2) + x;
solve Poisson(u, v) = int2d(Th)(dx(u) * dx(v) + dy(u) * dy(v))
  - int2d(Th)(pi * pi / 2 * sin(pi * x / 2) * sin(pi * y / 2) * v)
  + on(1, 2, 3, 4, 5, u = exact);
cout.precision(12);
cout << int2d(Th, 7)(1.) << " " << int1d(Th, 5)(1.) << " " << int1d(Th, 2)(N.x) << " "
     << sqrt(int2d(Th)((u - exact)^2)) << endl;
"""
SPACE = """
mesh3 Th("m.mesh");
fespace Vh(Th, P1);
Vh u, v;
func exact = sin(pi * x / 2) * sin(pi * y / 2) * sin(pi * z / 2) + x;
solve Poisson(u, v) = int3d(Th)(dx(u) * dx(v) + dy(u) * dy(v) + dz(u) * dz(v))
  - int3d(Th)(3 * pi * pi / 4 * sin(pi * x / 2) * sin(pi * y / 2) * sin(pi * z / 2) * v)
  + on(1, 2, 3, 4, 5, 6, u = x);
cout.precision(12);
cout << int3d(Th, 3)(1.) << " " << int3d(Th, 4)(1.) << " " << int2d(Th, 9)(1.) << " "
     << int2d(Th, 4)(N.x) << " " << sqrt(int3d(Th)((u - exact)^2)) << endl;
"""


def run(command, folder):
    done = subprocess.run(command, cwd=folder, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=300, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def solve(dynmesh, name, text, script, edge):
    """The numbers that the script prints."""
    with tempfile.TemporaryDirectory() as folder:
        for file, content in ((name, text), ("poisson.edp", script)):
            with open(f"{folder}/{file}", "w", encoding="utf-8") as out:
                out.write(content)
        run([dynmesh, "mesh", name, "--inside", "--markers", "input", "--hmax", str(edge),
             "-o", "m.mesh"], folder)
        return [float(word) for word in
                run(["FreeFem++", "-nw", "-v", "0", "poisson.edp"], folder).split()]


def check(dynmesh, name, text, script, expected, edges):
    found = [solve(dynmesh, name, text, script, edge) for edge in edges]
    print(f"{name}: {found}")
    for row in found:
        if len(row) != len(expected) + 1 or any(
                abs(value - wanted) > 1e-9 for value, wanted in zip(row, expected)):
            sys.exit(f"{name}: FreeFEM found {row}, expected {expected} and an error")
    ratio = found[0][-1] / found[1][-1]
    print(f"{name}: ratio of errors {ratio:.2f}")
    if not 3 < ratio < 5.5:
        sys.exit(f"{name}: the error of linear elements should fall by about 4, not {ratio:.2f}")


def main():
    if shutil.which("FreeFem++") is None:
        print("skipped: FreeFem++ is not installed (deploy/install-packages examples)")
        return SKIPPED
    dynmesh = sys.argv[1]
    # Area without the hole, length of the hole, integral of the normal along side 2.
    check(dynmesh, "square.poly", SQUARE, PLANE, [4 - .16, 1.6, 2], (.2, .1))
    # Volumes of the regions, area between them, integral of the normal on side 4.
    check(dynmesh, "cubes.smesh", cubes(), SPACE, [7, 1, 6, 4], (.4, .2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
