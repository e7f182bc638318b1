// Features as an edit script: to repeat a failure with.
#ifndef DYNMESH_TESTS_CLIENT_CLEANING_INPUT_SCRIPT_H_
#define DYNMESH_TESTS_CLIENT_CLEANING_INPUT_SCRIPT_H_

#include <string>
#include <vector>

#include "core/io/script/edit_script.h"
#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

// In the unit square.
inline std::string ScriptOf(const std::vector<Feature>& features) {
  std::string script = io::FormatMeshLine(MeshOptions()) + "\n";
  for (const Feature& f : features) script += io::FormatEdit(Edit::Add(f)) + "\n";
  return script;
}

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_TESTS_CLIENT_CLEANING_INPUT_SCRIPT_H_
