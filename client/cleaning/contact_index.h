// Do faces meet, or nearly meet, elsewhere than in common corners and edges? That faces do not meet
// is decided exactly, that they are a distance apart in doubles.
//
// Thread-compatible. A search is O(lg n) expected, and O(1) for each element with a box that meets.
#ifndef DYNMESH_CLIENT_CLEANING_CONTACT_INDEX_H_
#define DYNMESH_CLIENT_CLEANING_CONTACT_INDEX_H_

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "client/cleaning/node_table.h"

namespace dynmesh::cleaning {

// A face, an edge or a point: of 3, 2 or 1 corners.
struct ContactElement {
  std::array<Node, 3> v{};  // the first `size`, ascending
  int size = 0;
};

// Does `face` meet `other` elsewhere than in the corners and edges that both have? What is opposite
// to these must be `distance` apart, too. A face with the same corners is a contact.
bool HasContact(std::span<const Point3> points, const ContactElement& face,
                const ContactElement& other, double distance);

// Elements by their boxes.
class ContactIndex {
 public:
  // `points` must live as long.
  ContactIndex(std::span<const Point3> points, double distance);
  ~ContactIndex();

  // REQUIRES: `id` is not in the index.
  void Insert(std::uint32_t id, const ContactElement& element);
  // REQUIRES: it was inserted with these corners.
  void Remove(std::uint32_t id, const ContactElement& element);
  // Has one of the faces a contact with an element, except those that are left out?
  bool HasContacts(std::span<const ContactElement> faces,
                   absl::FunctionRef<bool(std::uint32_t)> is_left_out) const;
  // Is a corner of an element, except those that are left out, in one of the tetrahedra or on its
  // boundary? Exact. Their own corners are not looked at, nor tetrahedra without volume.
  bool HasCornersIn(std::span<const std::array<Node, 4>> tetrahedra,
                    absl::FunctionRef<bool(std::uint32_t)> is_left_out) const;

 private:
  struct Tree;

  const std::span<const Point3> points_;
  const double distance_;
  std::vector<ContactElement> elements_;  // by id
  std::unique_ptr<Tree> tree_;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_CONTACT_INDEX_H_
