/* A crack that grows through a plate, with a field: crack.c of four programs that print the same. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dynmesh.h"

enum { STEPS = 100 };

static void check(int code, const dynmesh_error *error) {
  if (code == DYNMESH_OK) return;
  fprintf(stderr, "%d %s: %s\n", code, error->reason, error->message);
  exit(1);
}

int main(void) {
  dynmesh_error error;
  dynmesh_options options;
  dynmesh_mesh *mesh;
  dynmesh_batch *batch;
  dynmesh_part *part;
  dynmesh_choice choice;
  dynmesh_field p1;
  dynmesh_column column;

  dynmesh_default_options(2, &options);
  options.max_edge = 0.05;
  check(dynmesh_open(&options, &mesh, &error), &error);
  check(dynmesh_batch_new(&batch, &error), &error);

  const uint64_t corners[] = {1, 2, 3, 4}, ring_end = 4, mouth = 5;
  const double places[] = {0, 0, 1, 0, 1, 1, 0, 1}, mouth_place[] = {0.125, 0.5};
  check(dynmesh_add_points(batch, DYNMESH_ADD, dynmesh_u64s(corners, 4), dynmesh_f64s(places, 4, 2),
                           &error), &error);
  check(dynmesh_add_polygon(batch, DYNMESH_ADD, 9, dynmesh_u64s(corners, 4),
                            dynmesh_u64s(&ring_end, 1), &error), &error);
  check(dynmesh_add_points(batch, DYNMESH_ADD, dynmesh_u64s(&mouth, 1),
                           dynmesh_f64s(mouth_place, 1, 2), &error), &error);
  check(dynmesh_apply(mesh, batch, NULL, &error), &error);

  dynmesh_default_choice(&choice);
  check(dynmesh_part_new(mesh, &choice, &part, &error), &error);

  size_t rows = (size_t)dynmesh_count(mesh, DYNMESH_VERTEX_SLOTS);
  double *u = malloc(rows * sizeof *u);
  if (u == NULL) return 1;
  check(dynmesh_array(mesh, DYNMESH_POINTS, &column, &error), &error);
  for (size_t i = 0; i < rows; ++i) {
    const double *p = (const double *)((const char *)column.data + (ptrdiff_t)i * column.stride);
    u[i] = p[0] * p[0] + 3 * p[1];
  }

  dynmesh_default_field(&p1);
  for (int k = 0; k < STEPS; ++k) {
    const uint64_t point = 101 + (uint64_t)k, segment = 301 + (uint64_t)k;
    const uint64_t ends[] = {k == 0 ? mouth : point - 1, point};
    const double place[] = {0.125 + (k + 1) / 160.0, 0.5 + ((k * 7) % 13 - 6) / 4096.0};
    dynmesh_batch_clear(batch);
    check(dynmesh_add_points(batch, DYNMESH_ADD, dynmesh_u64s(&point, 1), dynmesh_f64s(place, 1, 2),
                             &error), &error);
    check(dynmesh_add_segments(batch, DYNMESH_ADD, dynmesh_u64s(&segment, 1),
                               dynmesh_u64_pairs(ends, 1), &error), &error);
    check(dynmesh_apply(mesh, batch, NULL, &error), &error);
    const size_t now = (size_t)dynmesh_count(mesh, DYNMESH_VERTEX_SLOTS);
    if (now > rows) {
      double *larger = realloc(u, now * sizeof *u);
      if (larger == NULL) return 1;
      memset(larger + rows, 0, (now - rows) * sizeof *u);
      u = larger, rows = now;
    }
    check(dynmesh_carry(mesh, &p1, u, rows, sizeof *u, &error), &error);
    check(dynmesh_part_update(part, mesh, &error), &error);
  }

  double sum = 0;
  check(dynmesh_array(mesh, DYNMESH_VERTEX_IDS, &column, &error), &error);
  for (size_t i = 0; i < rows; ++i) {
    if (((const uint64_t *)column.data)[i] != 0) sum += u[i];
  }
  uint64_t bits;
  memcpy(&bits, &sum, sizeof bits);
  char hash[33];
  dynmesh_hash(mesh, hash);
  check(dynmesh_part_array(part, DYNMESH_PART_CELLS, &column, &error), &error);
  printf("%s %016" PRIx64 " %zu\n", hash, bits, column.rows);
  free(u);
  dynmesh_part_free(part);
  dynmesh_batch_free(batch);
  dynmesh_close(mesh);
  return 0;
}
