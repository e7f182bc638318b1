// The shapes of sizing features as a table: what each is called, and which members it uses. What
// depends on that alone reads it here: validation, edit scripts, cleaning.
#ifndef DYNMESH_CORE_BASE_SIZE_SHAPES_H_
#define DYNMESH_CORE_BASE_SIZE_SHAPES_H_

#include <iterator>
#include <string>
#include <string_view>

#include "dynmesh/feature.h"

namespace dynmesh {

struct SizeShapeUse {
  SizeShape shape;
  std::string_view name;  // in edit scripts
  bool position = false;  // Feature::position
  bool in_box = false;    // its positions must lie in the mesh's box
  bool radius = false;    // Sizing::radius
  bool hi = false;        // Sizing::hi
  bool rings = false;     // Feature::rings
  bool path = false;      // Sizing::path
};

inline constexpr SizeShapeUse kSizeShapes[] = {
    {.shape = SizeShape::kPoint, .name = "point", .position = true, .in_box = true},
    {.shape = SizeShape::kDisc, .name = "disc", .position = true, .in_box = true, .radius = true},
    {.shape = SizeShape::kBox, .name = "box", .position = true, .hi = true},
    {.shape = SizeShape::kPolygon, .name = "polygon", .rings = true},
    {.shape = SizeShape::kCapsule, .name = "capsule", .in_box = true, .radius = true, .path = true},
};

// Null if there is no such shape. Thread-safe.
inline const SizeShapeUse* FindUse(SizeShape shape) {
  for (const SizeShapeUse& use : kSizeShapes) {
    if (use.shape == shape) return &use;
  }
  return nullptr;
}
inline const SizeShapeUse* FindUse(std::string_view name) {
  for (const SizeShapeUse& use : kSizeShapes) {
    if (use.name == name) return &use;
  }
  return nullptr;
}

// "point, disc, box, polygon or capsule", for messages; each with `article` before it. In 3D
// without those of rings, which have no inside there.
inline std::string NamesOfSizeShapes(std::string_view article = "", int dimension = 2) {
  std::string names;
  for (const SizeShapeUse& use : kSizeShapes) {
    if (use.rings && dimension == 3) continue;
    const bool last = &use == std::end(kSizeShapes) - 1;
    if (!names.empty()) names += last ? " or " : ", ";
    names.append(article).append(use.name);
  }
  return names;
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_SIZE_SHAPES_H_
