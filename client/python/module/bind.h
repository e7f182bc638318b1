// The parts of the extension modules; each adds its classes. `_core` has all but the client, which
// is
// `_service`: that one alone needs gRPC. They share the types that `_core` binds.
#ifndef DYNMESH_CLIENT_PYTHON_MODULE_BIND_H_
#define DYNMESH_CLIENT_PYTHON_MODULE_BIND_H_

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::python {

// Shared, so that a diff can be kept and applied later.
struct Diff {
  MeshDiff diff;
  bool replayed = false;
};

// A batch that Python fills column by column.
struct Batch {
  EditBatch edits;
  int dimension = 2;
};

// Converts the features of a batch or a mesh to Python objects, and back.
pybind11::list FeatureDicts(const std::vector<Feature>& features, int dimension);
// Tuples of id, marker and name.
pybind11::list LabelTuples(const LabelColumn& labels);
pybind11::dict OptionsDict(const MeshOptions& options);
MeshOptions OptionsOf(const pybind11::dict& options);

// Writes a mesh, or a part of one, as dynmesh::WriteMesh. `choices`: members of OutputChoices.
void Write(const Mesh& mesh, const pybind11::dict& options, const std::string& path,
           const pybind11::dict& choices, bool is_part);

void BindEdits(pybind11::module_& module);
void BindMesh(pybind11::module_& module);
void BindTransfer(pybind11::module_& module);
void BindPart(pybind11::module_& module);
void BindFiles(pybind11::module_& module);
void BindColumns(pybind11::module_& module);
// Of `_service`.
void BindClient(pybind11::module_& module);

}  // namespace dynmesh::python

#endif  // DYNMESH_CLIENT_PYTHON_MODULE_BIND_H_
