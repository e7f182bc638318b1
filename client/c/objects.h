// What the handles of dynmesh.h stand for.
#ifndef DYNMESH_CLIENT_C_OBJECTS_H_
#define DYNMESH_CLIENT_C_OBJECTS_H_

#include <memory>
#include <optional>
#include <utility>

#include "client/c/dynmesh.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/feature.h"
#include "dynmesh/files.h"
#include "dynmesh/part.h"
#include "dynmesh/slot_mesh.h"
#include "dynmesh/transfer.h"

struct dynmesh_batch {
  dynmesh::EditBatch edits;
};

// Mesher and slots are at the same revision.
struct dynmesh_mesh {
  dynmesh_mesh(std::unique_ptr<dynmesh::DynamicMesh> m, dynmesh::SlotMesh s)
      : mesher(std::move(m)), slots(std::move(s)) {}

  std::unique_ptr<dynmesh::DynamicMesh> mesher;
  dynmesh::SlotMesh slots;
  dynmesh::MeshDiff diff;                     // the last one that was not empty
  bool has_diff = false;                      // is there one?
  std::optional<dynmesh::Transfer> transfer;  // across it, once it is needed
  bool was_empty = false;                     // the last batch applied has changed nothing
  bool is_lost = false;                       // an edit was broken off
};

struct dynmesh_part {
  dynmesh::PartChoice choice;
  dynmesh::MeshPart part;
};

struct dynmesh_input {
  dynmesh::MeshOptions options;
  dynmesh_batch batch;
};

#endif  // DYNMESH_CLIENT_C_OBJECTS_H_
