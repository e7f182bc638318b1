/* What dynmesh.h says of errors, strides, files and callbacks. Ends with 0 if all holds. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dynmesh.h"
#include "expect.h"

static int at_once(void *context) {
  ++*(int *)context;
  return 1;
}

/* Rows of a program: what the library wants lies between other things. */
struct node {
  uint64_t id;
  double weight, x, y;
};

static const struct node kNodes[] = {{1, 7, 0.25, 0.25}, {2, 7, 0.75, 0.25}, {3, 7, 0.5, 0.75}};

static dynmesh_column ids_of_nodes(size_t rows) {
  dynmesh_column c = {&kNodes[0].id, rows, sizeof(struct node), 1, DYNMESH_U64};
  return c;
}
static dynmesh_column places_of_nodes(size_t rows) {
  dynmesh_column c = {&kNodes[0].x, rows, sizeof(struct node), 2, DYNMESH_F64};
  return c;
}

static void columns_are_checked(dynmesh_batch *batch) {
  dynmesh_error error;
  dynmesh_column wrong = places_of_nodes(3);
  wrong.type = DYNMESH_I32;
  EXPECT(dynmesh_add_points(batch, DYNMESH_ADD, ids_of_nodes(3), wrong, &error) ==
         DYNMESH_INVALID_ARGUMENT);
  EXPECT(strstr(error.message, "places") != NULL && error.edit == -1);
  wrong = places_of_nodes(3), wrong.width = 4;
  EXPECT(dynmesh_add_points(batch, DYNMESH_ADD, ids_of_nodes(3), wrong, NULL) ==
         DYNMESH_INVALID_ARGUMENT);
  wrong = places_of_nodes(3), wrong.data = NULL;
  EXPECT(dynmesh_add_points(batch, DYNMESH_ADD, ids_of_nodes(3), wrong, NULL) ==
         DYNMESH_INVALID_ARGUMENT);
  wrong = places_of_nodes(3), wrong.stride = 4;
  EXPECT(dynmesh_add_points(batch, DYNMESH_ADD, ids_of_nodes(3), wrong, NULL) ==
         DYNMESH_INVALID_ARGUMENT);
  wrong = places_of_nodes(3), wrong.data = (const char *)wrong.data + 4;
  EXPECT(dynmesh_add_points(batch, DYNMESH_ADD, ids_of_nodes(3), wrong, &error) ==
         DYNMESH_INVALID_ARGUMENT);
  EXPECT(strstr(error.message, "multiple of 8") != NULL);
  wrong = places_of_nodes(SIZE_MAX / 8), wrong.stride = 0;
  dynmesh_column ids = ids_of_nodes(SIZE_MAX / 8);
  ids.stride = 0;
  EXPECT(dynmesh_add_points(batch, DYNMESH_ADD, ids, wrong, NULL) == DYNMESH_INVALID_ARGUMENT);
  EXPECT(dynmesh_add_points(batch, DYNMESH_ADD, ids_of_nodes(2), places_of_nodes(3), NULL) ==
         DYNMESH_INVALID_ARGUMENT);
  EXPECT(dynmesh_add_points(batch, 7, ids_of_nodes(3), places_of_nodes(3), NULL) ==
         DYNMESH_INVALID_ARGUMENT);
  uint64_t end = 4;
  EXPECT(dynmesh_add_polygon(batch, DYNMESH_ADD, 9, ids_of_nodes(3), dynmesh_u64s(&end, 1), NULL) ==
         DYNMESH_INVALID_ARGUMENT);
  EXPECT(dynmesh_batch_count(batch) == 0);
}

static void a_refused_batch_changes_nothing(dynmesh_mesh *mesh, dynmesh_batch *batch) {
  dynmesh_error error;
  char before[33], after[33];
  dynmesh_hash(mesh, before);
  const uint64_t id = 4, absent[] = {1, 99};
  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_add_segments(batch, DYNMESH_ADD, dynmesh_u64s(&id, 1),
                               dynmesh_u64_pairs(absent, 1), NULL));
  EXPECT(dynmesh_apply(mesh, batch, NULL, &error) == DYNMESH_FAILED_PRECONDITION);
  EXPECT(strcmp(error.reason, "UNKNOWN_END") == 0 && error.edit == 0 && error.code != DYNMESH_OK);
  EXPECT(error.feature_count >= 1 && (error.features[0] == 4 || error.features[0] == 99));

  dynmesh_apply_options options;
  int calls = 0;
  const uint64_t ends[] = {1, 2};
  dynmesh_default_apply_options(&options);
  options.interrupted = at_once, options.context = &calls;
  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_add_segments(batch, DYNMESH_ADD, dynmesh_u64s(&id, 1), dynmesh_u64_pairs(ends, 1),
                               NULL));
  EXPECT(dynmesh_apply(mesh, batch, &options, &error) == DYNMESH_CANCELLED && calls > 0);
  options.size = 1;
  EXPECT(dynmesh_apply(mesh, batch, &options, &error) == DYNMESH_INVALID_ARGUMENT);
  dynmesh_hash(mesh, after);
  EXPECT(strcmp(before, after) == 0 && dynmesh_revision(mesh) == 1);
}

/* Rows from the last one to the first: the same features. */
static void strides_may_be_negative(void) {
  dynmesh_error error;
  dynmesh_options options;
  dynmesh_batch *batch;
  char hashes[2][33];
  dynmesh_default_options(2, &options);
  for (int i = 0; i < 2; ++i) {
    dynmesh_mesh *mesh;
    dynmesh_column ids = ids_of_nodes(3), places = places_of_nodes(3);
    if (i == 1) {
      ids.data = &kNodes[2].id, ids.stride = -ids.stride;
      places.data = &kNodes[2].x, places.stride = -places.stride;
    }
    EXPECT(!dynmesh_open(&options, &mesh, &error) && !dynmesh_batch_new(&batch, &error));
    EXPECT(!dynmesh_add_points(batch, DYNMESH_ADD, ids, places, &error));
    EXPECT(!dynmesh_apply(mesh, batch, NULL, &error));
    dynmesh_hash(mesh, hashes[i]);
    dynmesh_batch_free(batch);
    dynmesh_close(mesh);
  }
  EXPECT(strcmp(hashes[0], hashes[1]) == 0);
}

static void labels_sizes_moves(dynmesh_mesh *mesh, dynmesh_batch *batch) {
  dynmesh_error error;
  char before[33], after[33];
  dynmesh_hash(mesh, before);
  const uint64_t size = 50, moved = 3;
  const double there[] = {0.5, 0.8}, back[] = {0.5, 0.75}, radius = 0.1, target = 0.02;
  const dynmesh_column none = {NULL, 0, 0, 1, DYNMESH_F64};
  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_add_sizes(batch, DYNMESH_ADD, dynmesh_u64s(&size, 1), dynmesh_f64s(there, 1, 2),
                            dynmesh_f64s(&radius, 1, 1), dynmesh_f64s(&target, 1, 1), &error));
  EXPECT(!dynmesh_add_sizes(batch, DYNMESH_SET, dynmesh_u64s(&size, 1), dynmesh_f64s(there, 1, 2), none,
                            dynmesh_f64s(&target, 1, 1), &error));
  EXPECT(!dynmesh_set_label(batch, 1, 7, "wall", &error));
  EXPECT(!dynmesh_move_points(batch, dynmesh_u64s(&moved, 1), dynmesh_f64s(there, 1, 2), &error));
  EXPECT(!dynmesh_apply(mesh, batch, NULL, &error));
  EXPECT(dynmesh_count(mesh, DYNMESH_FEATURES) == 4);
  dynmesh_hash(mesh, after);
  EXPECT(strcmp(before, after) != 0);
  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_remove(batch, dynmesh_u64s(&size, 1), &error));
  EXPECT(!dynmesh_move_points(batch, dynmesh_u64s(&moved, 1), dynmesh_f64s(back, 1, 2), &error));
  EXPECT(!dynmesh_apply(mesh, batch, NULL, &error));
  dynmesh_hash(mesh, after);
  EXPECT(strcmp(before, after) == 0); /* undo is the inverse edit */
}

static void arrays_and_diffs_agree(const dynmesh_mesh *mesh) {
  dynmesh_error error;
  dynmesh_column cells, points, ids, added, removed;
  EXPECT(!dynmesh_array(mesh, DYNMESH_CELLS, &cells, &error) && cells.width == 3);
  EXPECT(!dynmesh_array(mesh, DYNMESH_POINTS, &points, &error) && points.width == 2);
  EXPECT(!dynmesh_array(mesh, DYNMESH_VERTEX_IDS, &ids, &error) && ids.type == DYNMESH_U64);
  EXPECT(points.rows == ids.rows && ids.rows == dynmesh_count(mesh, DYNMESH_VERTEX_SLOTS));
  EXPECT(cells.rows == dynmesh_count(mesh, DYNMESH_CELL_SLOTS));
  size_t used = 0;
  for (size_t i = 0; i < ids.rows; ++i) used += ((const uint64_t *)ids.data)[i] != 0;
  EXPECT(used == dynmesh_count(mesh, DYNMESH_VERTICES));
  EXPECT(!dynmesh_diff(mesh, DYNMESH_ADDED_VERTICES, &added, &error));
  EXPECT(!dynmesh_diff(mesh, DYNMESH_REMOVED_VERTICES, &removed, &error) && removed.rows > 0);
  for (size_t i = 0; i < added.rows; ++i) {
    EXPECT(((const uint64_t *)ids.data)[((const int32_t *)added.data)[i]] != 0);
  }
  EXPECT(dynmesh_array(mesh, 99, &cells, &error) == DYNMESH_INVALID_ARGUMENT);
  EXPECT(dynmesh_diff(mesh, 99, &cells, &error) == DYNMESH_INVALID_ARGUMENT);

  const double places[] = {0.5, 0.5, 1e6, 0};
  int32_t found[2] = {-7, -7};
  EXPECT(!dynmesh_locate(mesh, dynmesh_f64s(places, 2, 2), found, &error));
  EXPECT(found[0] >= 0 && found[1] == -1);
  EXPECT(dynmesh_locate(mesh, dynmesh_f64s(places, 2, 2), NULL, &error) ==
         DYNMESH_INVALID_ARGUMENT);
  EXPECT(!dynmesh_locate(mesh, dynmesh_f64s(NULL, 0, 2), NULL, &error));
  dynmesh_column all = dynmesh_f64s(places, SIZE_MAX / 2 + 1, 2);
  all.stride = 0;
  EXPECT(dynmesh_locate(mesh, all, found, &error) == DYNMESH_INVALID_ARGUMENT);
  EXPECT(dynmesh_locate(mesh, dynmesh_f64s(places, 1, 3), found, &error) ==
         DYNMESH_INVALID_ARGUMENT);
}

/* Two interleaved fields, by a stride, as each alone. */
static void strides_of_fields(dynmesh_mesh *mesh, dynmesh_batch *batch) {
  dynmesh_error error;
  dynmesh_field p1;
  dynmesh_column points;
  const uint64_t id = 60;
  const double place[] = {0.4, 0.5};
  dynmesh_default_field(&p1);
  const size_t before = (size_t)dynmesh_count(mesh, DYNMESH_VERTEX_SLOTS);
  double *both = calloc(4 * before + 1000, sizeof(double)), *one = both + 3 * before + 500;
  EXPECT(!dynmesh_array(mesh, DYNMESH_POINTS, &points, &error));
  for (size_t i = 0; i < before; ++i) {
    both[2 * i] = one[i] = 1 + ((const double *)points.data)[2 * i];
    both[2 * i + 1] = -1;
  }
  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_add_points(batch, DYNMESH_ADD, dynmesh_u64s(&id, 1), dynmesh_f64s(place, 1, 2), &error));
  EXPECT(!dynmesh_apply(mesh, batch, NULL, &error));
  const size_t rows = (size_t)dynmesh_count(mesh, DYNMESH_VERTEX_SLOTS);
  EXPECT(dynmesh_carry(mesh, &p1, one, rows + 1, 8, &error) == DYNMESH_INVALID_ARGUMENT);
  EXPECT(dynmesh_carry(mesh, &p1, one, rows, 4, &error) == DYNMESH_INVALID_ARGUMENT);
  EXPECT(dynmesh_carry(mesh, &p1, one, rows, -8, &error) == DYNMESH_INVALID_ARGUMENT);
  EXPECT(dynmesh_carry(mesh, &p1, NULL, rows, 8, &error) == DYNMESH_INVALID_ARGUMENT);
  EXPECT(dynmesh_carry(mesh, &p1, (double *)((char *)one + 4), rows, 8, &error) ==
         DYNMESH_INVALID_ARGUMENT);
  EXPECT(!dynmesh_carry(mesh, &p1, one, rows, 8, &error));
  EXPECT(!dynmesh_carry(mesh, &p1, both, rows, 16, &error));
  for (size_t i = 0; i < before; ++i) EXPECT(both[2 * i] == one[i] && both[2 * i + 1] == -1);
  p1.kind = 99;
  EXPECT(dynmesh_carry(mesh, &p1, one, rows, 8, &error) == DYNMESH_INVALID_ARGUMENT);
  free(both);
}

/* The last dynmesh_apply is that of an empty batch: its diff is empty, and nothing is carried. */
static void an_empty_batch_carries_nothing(dynmesh_mesh *mesh, dynmesh_batch *batch) {
  dynmesh_error error;
  dynmesh_field p1;
  dynmesh_column column;
  const uint64_t id = 61;
  const double place[] = {0.45, 0.55};
  dynmesh_default_field(&p1);
  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_add_points(batch, DYNMESH_ADD, dynmesh_u64s(&id, 1), dynmesh_f64s(place, 1, 2), &error));
  EXPECT(!dynmesh_apply(mesh, batch, NULL, &error));
  const uint64_t revision = dynmesh_revision(mesh);
  const size_t rows = (size_t)dynmesh_count(mesh, DYNMESH_VERTEX_SLOTS);
  double *values = calloc(2 * rows, sizeof *values), *before = values + rows;
  for (size_t i = 0; i < rows; ++i) values[i] = before[i] = (double)(i * i % 17);
  /* A refused batch does not count: the diff is that of the one before. */
  EXPECT(dynmesh_apply(mesh, batch, NULL, &error) == DYNMESH_ALREADY_EXISTS);
  EXPECT(!dynmesh_diff(mesh, DYNMESH_ADDED_CELLS, &column, &error) && column.rows > 0);

  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_apply(mesh, batch, NULL, &error) && dynmesh_revision(mesh) == revision);
  for (int which = DYNMESH_REMOVED_VERTICES; which <= DYNMESH_FORMER_REGIONS; ++which) {
    EXPECT(!dynmesh_diff(mesh, which, &column, &error) && column.rows == 0);
    EXPECT(column.width == (which == DYNMESH_REMOVED_CORNERS ? 3 : 1));
  }
  EXPECT(dynmesh_diff(mesh, 99, &column, &error) == DYNMESH_INVALID_ARGUMENT);
  EXPECT(!dynmesh_carry(mesh, &p1, values, rows, 8, &error));
  EXPECT(memcmp(values, before, rows * sizeof *values) == 0);
  EXPECT(dynmesh_carry(mesh, &p1, values, rows + 1, 8, &error) == DYNMESH_INVALID_ARGUMENT);

  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_remove(batch, dynmesh_u64s(&id, 1), &error));
  EXPECT(!dynmesh_apply(mesh, batch, NULL, &error));
  EXPECT(!dynmesh_diff(mesh, DYNMESH_ADDED_CELLS, &column, &error) && column.rows > 0);
  free(values);
}

/* Options of a program that was compiled for an earlier header, and of one for a later one. */
static void structures_of_other_sizes(dynmesh_mesh *mesh) {
  struct {
    dynmesh_options known;
    double later[4];
  } larger;
  struct {
    dynmesh_choice known;
    int64_t later;
  } choice;
  dynmesh_error error;
  dynmesh_options usual, smaller;
  dynmesh_mesh *others[2];
  char hashes[2][33];
  const size_t size = offsetof(dynmesh_options, quality);

  dynmesh_default_options(3, &usual);
  memset(&smaller, 0x5a, sizeof smaller);
  dynmesh_fill_options(3, &smaller, size);
  EXPECT(smaller.size == size && usual.size == sizeof usual);
  EXPECT(memcmp(&smaller.dimension, &usual.dimension,
                size - offsetof(dynmesh_options, dimension)) == 0);
  for (size_t i = size; i < sizeof smaller; ++i) EXPECT(((unsigned char *)&smaller)[i] == 0x5a);
  EXPECT(!dynmesh_open(&usual, &others[0], &error));
  EXPECT(!dynmesh_open(&smaller, &others[1], &error)); /* with the quality that is usual in 3D */
  for (int i = 0; i < 2; ++i) dynmesh_hash(others[i], hashes[i]), dynmesh_close(others[i]);
  EXPECT(strcmp(hashes[0], hashes[1]) == 0);

  memset(&larger, 0x5a, sizeof larger);
  dynmesh_fill_options(2, &larger.known, sizeof larger);
  EXPECT(larger.known.size == sizeof larger && larger.known.max_vertices == usual.max_vertices);
  for (int i = 0; i < 4; ++i) EXPECT(larger.later[i] == 0);
  EXPECT(!dynmesh_open(&larger.known, &others[0], &error));
  dynmesh_close(others[0]);
  larger.known.size = sizeof larger.known.size;
  EXPECT(dynmesh_open(&larger.known, &others[0], &error) == DYNMESH_INVALID_ARGUMENT);

  dynmesh_apply_options apply;
  dynmesh_batch *empty;
  memset(&apply, 0x5a, sizeof apply);
  dynmesh_fill_apply_options(&apply, offsetof(dynmesh_apply_options, max_operations));
  EXPECT(apply.interrupted == NULL && apply.max_operations == 0x5a5a5a5a5a5a5a5a);
  EXPECT(!dynmesh_batch_new(&empty, &error) && !dynmesh_apply(mesh, empty, &apply, &error));
  dynmesh_batch_free(empty);

  dynmesh_field field;
  const size_t rows = (size_t)dynmesh_count(mesh, DYNMESH_VERTEX_SLOTS);
  double *values = calloc(rows, sizeof *values);
  memset(&field, 0x5a, sizeof field);
  dynmesh_fill_field(&field, offsetof(dynmesh_field, components));
  EXPECT(field.kind == DYNMESH_P1 && field.components == 0x5a5a5a5a);
  EXPECT(!dynmesh_carry(mesh, &field, values, rows, 8, &error)); /* one component */
  free(values);

  dynmesh_part *part;
  memset(&choice, 0x5a, sizeof choice);
  dynmesh_fill_choice(&choice.known, sizeof choice);
  EXPECT(choice.known.inside == 1 && choice.later == 0);
  EXPECT(!dynmesh_part_new(mesh, &choice.known, &part, &error));
  dynmesh_part_free(part);
  memset(&choice, 0x5a, sizeof choice);
  dynmesh_fill_choice(&choice.known, offsetof(dynmesh_choice, open));
  EXPECT(choice.known.inside == 0x5a5a5a5a);
  EXPECT(!dynmesh_part_new(mesh, &choice.known, &part, &error));
  dynmesh_part_free(part);
}

static void files(const char *folder, dynmesh_mesh *mesh, dynmesh_batch *batch) {
  dynmesh_error error;
  dynmesh_input *input;
  dynmesh_mesh *other;
  dynmesh_options options;
  dynmesh_part *part;
  dynmesh_choice choice;
  char path[1000];
  EXPECT(dynmesh_read("/nowhere.poly", 0, &input, &error) == DYNMESH_NOT_FOUND && input == NULL);
  snprintf(path, sizeof path, "%s/plate.poly", folder);
  FILE *file = fopen(path, "w");
  fputs("4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n", file);
  fclose(file);
  EXPECT(!dynmesh_read(path, 0, &input, &error));
  dynmesh_input_options(input, &options);
  dynmesh_options smaller;
  memset(&smaller, 0x5a, sizeof smaller);
  dynmesh_input_fill_options(input, &smaller, offsetof(dynmesh_options, high));
  EXPECT(memcmp(smaller.low, options.low, sizeof options.low) == 0 &&
         smaller.max_vertices == 0x5a5a5a5a5a5a5a5a);
  EXPECT(options.dimension == 2 && dynmesh_batch_count(dynmesh_input_batch(input)) == 8);
  EXPECT(!dynmesh_open(&options, &other, &error));
  EXPECT(!dynmesh_apply(other, dynmesh_input_batch(input), NULL, &error));
  snprintf(path, sizeof path, "%s/plate.msh", folder);
  EXPECT(!dynmesh_write(other, NULL, path, DYNMESH_BINARY, &error));
  EXPECT(dynmesh_write(other, NULL, "/plate.unknown", 0, &error) == DYNMESH_INVALID_ARGUMENT);
  dynmesh_close(other);
  dynmesh_input_free(input);

  /* A part that has missed a batch is made anew. */
  uint64_t end = 3;
  dynmesh_default_choice(&choice);
  EXPECT(!dynmesh_part_new(mesh, &choice, &part, &error));
  dynmesh_column cells;
  EXPECT(!dynmesh_part_array(part, DYNMESH_PART_CELLS, &cells, &error) && cells.rows == 0);
  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_add_polygon(batch, DYNMESH_ADD, 9, ids_of_nodes(3), dynmesh_u64s(&end, 1), &error));
  EXPECT(!dynmesh_apply(mesh, batch, NULL, &error));
  dynmesh_batch_clear(batch);
  EXPECT(!dynmesh_set_label(batch, 9, 1, "plate", &error));
  EXPECT(!dynmesh_apply(mesh, batch, NULL, &error));
  EXPECT(!dynmesh_part_update(part, mesh, &error));
  EXPECT(!dynmesh_part_array(part, DYNMESH_PART_CELLS, &cells, &error) && cells.rows > 0);
  snprintf(path, sizeof path, "%s/part.vtu", folder);
  EXPECT(!dynmesh_write(mesh, part, path, 0, &error));
  EXPECT(dynmesh_part_array(part, 99, &cells, &error) == DYNMESH_INVALID_ARGUMENT);
  dynmesh_part_free(part);
}

int main(int argc, char **argv) {
  dynmesh_error error;
  dynmesh_options options;
  dynmesh_mesh *mesh = NULL;
  dynmesh_batch *batch = NULL;
  (void)argc;
  EXPECT(strcmp(dynmesh_version(), "") != 0);
  memset(&options, 0, sizeof options);
  EXPECT(dynmesh_open(&options, &mesh, &error) == DYNMESH_INVALID_ARGUMENT && mesh == NULL);
  dynmesh_default_options(2, &options);
  options.quality = 0.5;
  EXPECT(dynmesh_open(&options, &mesh, &error) == DYNMESH_INVALID_ARGUMENT);
  EXPECT(strcmp(error.reason, "BAD_OPTION") == 0);
  dynmesh_default_options(2, &options);
  EXPECT(!dynmesh_open(&options, &mesh, &error) && error.code == DYNMESH_OK);
  EXPECT(!dynmesh_batch_new(&batch, &error));
  dynmesh_field p1;
  double nothing = 0;
  dynmesh_default_field(&p1);
  EXPECT(dynmesh_carry(mesh, &p1, &nothing, 1, 8, &error) == DYNMESH_FAILED_PRECONDITION);

  columns_are_checked(batch);
  strides_may_be_negative();
  EXPECT(!dynmesh_add_points(batch, DYNMESH_ADD, ids_of_nodes(3), places_of_nodes(3), &error));
  EXPECT(!dynmesh_apply(mesh, batch, NULL, &error) && dynmesh_revision(mesh) == 1);
  a_refused_batch_changes_nothing(mesh, batch);
  labels_sizes_moves(mesh, batch);
  arrays_and_diffs_agree(mesh);
  strides_of_fields(mesh, batch);
  an_empty_batch_carries_nothing(mesh, batch);
  structures_of_other_sizes(mesh);
  files(argv[1], mesh, batch);
  dynmesh_batch_free(batch);
  dynmesh_batch_free(NULL);
  dynmesh_close(mesh);
  dynmesh_close(NULL);
  return failures != 0;
}
