#!/usr/bin/python3
"""The programs that the experiments measure run, and their figures are read.

    experiments_test.py DYNMESH
"""
import pathlib
import sys
import tempfile

EXPERIMENTS = pathlib.Path(__file__).resolve().parents[1] / "bench/experiments"
sys.path.insert(0, str(EXPERIMENTS))
import meshers  # noqa: E402
import solids  # noqa: E402
import surfaces  # noqa: E402


def main() -> None:
    program = pathlib.Path(sys.argv[1])
    box = solids.box()
    assert surfaces.is_closed(box) and not surfaces.is_closed(solids.fan(3, 30))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        path = folder / "box.off"
        solids.write_off(path, box)
        for engine in ("svr", "dynamic"):
            run = meshers.dynmesh_of_file(program, path, ["--engine", engine], 60)
            assert run is not None and run.vertices > 8 and run.tetrahedra > 5, run
        made = surfaces.by_dynmesh(program, path, True, 60, folder)
        assert isinstance(made, surfaces.Result) and made.verdict == "good", made
        assert made.vertices == 8, made
        solids.write_off(path, solids.triangulated(solids.box((0, 0, 0), (1, 2, 4))))
        counts = []
        for merged in (False, True):
            made = surfaces.by_dynmesh(program, path, True, 60, folder, merged)
            assert isinstance(made, surfaces.Result) and made.verdict == "good", made
            counts.append(made.vertices)
        assert counts[1] < counts[0], counts
        solids.write_off(path, box)
        if meshers.has_tetgen():
            for closed in (True, False):
                run = surfaces.by_tetgen(path, box, closed, 60, folder)
                assert run is not None and run.vertices >= 8, run


if __name__ == "__main__":
    main()
