// What commands print of a quadtree.
#ifndef DYNMESH_CLIENT_CLI_QUADTREE_TEXT_H_
#define DYNMESH_CLIENT_CLI_QUADTREE_TEXT_H_

#include <string>

#include "client/cli/json.h"
#include "client/verify/verify_quadtree.h"

namespace dynmesh::cli {

// Leaves by level, and lfs / side if it is known. Lines for people; members added to a
// JSON object, which is returned.
std::string QuadtreeText(const QuadtreeReport& report);
JsonObject& QuadtreeJson(const QuadtreeReport& report, JsonObject& object);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_QUADTREE_TEXT_H_
