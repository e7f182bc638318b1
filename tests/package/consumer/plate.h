// The input of both programs: a plate, and an edit of it.
#ifndef CONSUMER_PLATE_H_
#define CONSUMER_PLATE_H_

#include "dynmesh/feature.h"
#include "dynmesh/options.h"

inline dynmesh::MeshOptions PlateOptions() {
  dynmesh::MeshOptions options;
  options.box = {{0, 0}, {10, 10}};
  return options;
}

inline dynmesh::EditBatch Plate() {
  using dynmesh::Edit;
  using dynmesh::Feature;
  return {Edit::Add(Feature::Point(1, 2, 2)), Edit::Add(Feature::Point(2, 7, 4)),
          Edit::Add(Feature::Point(3, 2.1, 2.3))};
}

inline dynmesh::EditBatch Cut() { return {dynmesh::Edit::Add(dynmesh::Feature::Segment(4, 1, 2))}; }

#endif  // CONSUMER_PLATE_H_
