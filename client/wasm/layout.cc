// What dynmesh.mjs knows of the structures of dynmesh.h, as numbers of bytes. Checked here, where
// the compiler for WebAssembly knows better.
#include <cstddef>

#include "client/c/dynmesh.h"

static_assert(sizeof(dynmesh_column) == 20);
static_assert(offsetof(dynmesh_column, data) == 0);
static_assert(offsetof(dynmesh_column, rows) == 4);
static_assert(offsetof(dynmesh_column, stride) == 8);
static_assert(offsetof(dynmesh_column, width) == 12);
static_assert(offsetof(dynmesh_column, type) == 16);

static_assert(sizeof(dynmesh_error) == 1136);
static_assert(offsetof(dynmesh_error, code) == 0);
static_assert(offsetof(dynmesh_error, feature_count) == 4);
static_assert(offsetof(dynmesh_error, edit) == 8);
static_assert(offsetof(dynmesh_error, features) == 16);
static_assert(offsetof(dynmesh_error, reason) == 80);
static_assert(offsetof(dynmesh_error, message) == 112);

static_assert(sizeof(dynmesh_options) == 104);
static_assert(offsetof(dynmesh_options, dimension) == 4);
static_assert(offsetof(dynmesh_options, kind) == 8);
static_assert(offsetof(dynmesh_options, criterion) == 12);
static_assert(offsetof(dynmesh_options, low) == 24);
static_assert(offsetof(dynmesh_options, high) == 48);
static_assert(offsetof(dynmesh_options, quality) == 72);
static_assert(offsetof(dynmesh_options, max_edge) == 80);
static_assert(offsetof(dynmesh_options, min_dihedral) == 88);
static_assert(offsetof(dynmesh_options, max_vertices) == 96);

static_assert(sizeof(dynmesh_apply_options) == 24);
static_assert(offsetof(dynmesh_apply_options, max_operations) == 16);

static_assert(sizeof(dynmesh_field) == 20);
static_assert(offsetof(dynmesh_field, kind) == 4);
static_assert(offsetof(dynmesh_field, components) == 8);
static_assert(offsetof(dynmesh_field, rings) == 12);
static_assert(offsetof(dynmesh_field, bounded) == 16);

static_assert(sizeof(dynmesh_choice) == 72);
static_assert(offsetof(dynmesh_choice, polygons) == 4);
static_assert(offsetof(dynmesh_choice, without) == 24);
static_assert(offsetof(dynmesh_choice, open) == 44);
static_assert(offsetof(dynmesh_choice, inside) == 64);
