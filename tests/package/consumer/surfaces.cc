// Makes a mesh of a surface file that a mesh refuses, and prints how many edges were open.
#include <cstdio>

#include "dynmesh/surfaces.h"

int main(int, char** argv) {
  const auto made = dynmesh::BuildSurface(argv[1]);
  if (!made.ok()) return std::puts(made.status().ToString().c_str()), 1;
  const auto inside = dynmesh::KeepInside(made->mesh);
  if (!inside.ok()) return std::puts(inside.status().ToString().c_str()), 1;
  const dynmesh::SurfaceReport& report = made->surface.report;
  std::printf("%zu %zu %s\n", report.open_edges_read, report.open_edges,
              report.mended && report.farthest <= report.within ? "within" : "beyond");
}
