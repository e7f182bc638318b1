// Bytes that may be anything, made fit for a message, an answer or a line of the log: what is not
// UTF-8, and control characters, as \x and two hex digits. All else stays as it is. Pure, O(bytes).
#ifndef DYNMESH_SERVER_BASE_PRINTABLE_H_
#define DYNMESH_SERVER_BASE_PRINTABLE_H_

#include <string>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

std::string Printable(absl::string_view bytes);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_PRINTABLE_H_
