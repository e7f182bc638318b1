// Where the simplices of a surface touch and cross: the search of a round of cleaning.
//
// They touch where a node is on an edge or a face, within half the tolerance. They cross where two
// edges meet, within half the tolerance, and where an edge passes through a face: that is decided
// exactly, and constructed exactly, rounded once. So is the meeting of two edges in a plane.
//
// Candidates come from a tree of boxes. Pure, thread-safe. Expected O(n lg n) for n simplices, if
// each is near a bounded number of others.
#ifndef DYNMESH_CLIENT_CLEANING_SURFACE_CONTACTS_H_
#define DYNMESH_CLIENT_CLEANING_SURFACE_CONTACTS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/cleaning/effort.h"
#include "client/cleaning/surface.h"

namespace dynmesh::cleaning {

// Is the shadow of p, along the axis of the face's normal, strictly inside of it? Exact.
bool IsOver(const Surface& surface, const Simplex& face, const Point3& p);
// The axis of the shadow, and whether the face's corners are counter-clockwise in it.
struct FaceView {
  std::size_t axis = 0;
  bool is_counter_clockwise = true;
};
FaceView ViewOf(const Surface& surface, const Simplex& face);
// The point of the edge nearest to p, in doubles.
Point3 FootOn(const Surface& surface, NodePair edge, const Point3& p);

// Parts of a simplex: edges from 0, the face itself, corners from 4.
inline constexpr int kFaceItself = 3;
inline constexpr int kFirstCorner = 4;

// A place that two simplices have in common.
struct Contact {
  std::uint32_t s = 0, t = 0;  // simplices, s < t
  int part_of_s = 0, part_of_t = 0;
  Point3 place{};
  Node at = 0;      // if one of the parts is a corner; else found later
  double fold = 0;  // if they are folded onto each other: how far apart they are
};

// A face with a corner on its opposite edge: it is to go through that.
struct ThinFace {
  NodePair edge;
  Node at = 0;
  double fold = 0;  // as in Contact
};

struct Contacts {
  std::vector<Contact> pairs;
  std::vector<ThinFace> thin;
  bool is_cut_off = false;  // there are more than `most` pairs
  // More boxes meet than there are steps left, as in a fan of hundreds of needles: no pair was
  // compared.
  bool is_crowded = false;
  Point3 crowd{};  // a corner of one of them
};

// Of which one simplex has born >= `since`. Each pair with boxes that meet is a step.
Contacts FindContacts(const Surface& surface, int since, std::size_t most, Effort& effort);

// Are the corners of one nearly in the plane of the other? REQUIRES: two faces.
bool AreCoplanar(const Surface& surface, const Simplex& s, const Simplex& t);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_SURFACE_CONTACTS_H_
