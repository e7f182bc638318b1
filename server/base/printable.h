// Escapes arbitrary bytes for a message, an answer or a log line: invalid UTF-8 and control
// characters become \x and two hex digits. All else is unchanged. Pure, O(bytes).
#ifndef DYNMESH_SERVER_BASE_PRINTABLE_H_
#define DYNMESH_SERVER_BASE_PRINTABLE_H_

#include <string>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

std::string Printable(absl::string_view bytes);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_PRINTABLE_H_
