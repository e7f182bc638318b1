// Error reports of the checkers of triangulations. For core/delaunay only.
#ifndef DYNMESH_CORE_DELAUNAY_CHECK_FAILURE_H_
#define DYNMESH_CORE_DELAUNAY_CHECK_FAILURE_H_

#include <sstream>
#include <string>

namespace dynmesh::delaunay {

// Sets *why to the concatenation of the parts. Returns false.
template <class... Parts>
bool Fail(std::string* why, const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  *why = text.str();
  return false;
}

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_CHECK_FAILURE_H_
