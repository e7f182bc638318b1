// The cases of the golden hashes: inputs of every kind, 2D and 3D, and what they are meshed with.
//
// A case is options and a script of batches. Its line in hashes.txt holds
//   name  revisions  input  mesh  trace  all
// `revisions`: batches that were applied; `input`: a hash of the features at the end; `mesh`: the
// mesh's hash at the end; `trace`: the hash of the complete trace and the number of operations in
// it; `all`: a hash of the meshes and traces of all revisions.
//
// The lines of some cases go on with
//   snapshots  diffs
// `snapshots`: a hash of all columns of the meshes of all revisions, in canonical order: also
// region sets, and owners and regions row by row; `diffs`: the same of all diffs, without
// WorkCounters. So a diff with a row too many is noticed, though it leads to the same mesh.
//
// Random inputs use sines and cosines, and these differ in the last bits between processors. So
// coordinates are rounded to multiples of 2^-32 (solids with faces that must stay flat: 2^-44)
// where the purpose of the input allows it. If `input` differs from the file's, the machine made
// another input, and the other hashes say nothing.
#ifndef DYNMESH_TESTS_GOLDEN_GOLDEN_CASES_H_
#define DYNMESH_TESTS_GOLDEN_GOLDEN_CASES_H_

#include <functional>
#include <string>
#include <vector>

#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::test {

struct GoldenCase {
  std::string name;  // of letters, digits and underscores
  MeshOptions options;
  // The batch after `done` others, of a mesh with the features `present`; a batch may be refused.
  using NextBatch = std::function<EditBatch(int done, const std::vector<Feature>& present)>;
  // A fresh script; from the same case always the same.
  std::function<NextBatch()> script;
  int batches = 0;
  bool has_diffs = false;  // the line has `snapshots` and `diffs`
  bool is_valid = false;   // a refused batch is a fault
};

const std::vector<GoldenCase>& GoldenCases();

struct GoldenResult {
  std::string line;
  // Its faults, independent of any golden hash: dynamic, from scratch and static differ; so do
  // diffs of propagated and rebuilt batches.
  std::string problem;
};
GoldenResult RunGoldenCase(const GoldenCase& golden);

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_GOLDEN_GOLDEN_CASES_H_
