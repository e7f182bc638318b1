/* Memory that runs out: errors, and no end of the program. Ends with 0 if all holds. Needs glibc. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dynmesh.h"
#include "expect.h"

void *__libc_malloc(size_t size);

static long left = -1; /* allocations until memory runs out; below 0: it does not */

/* In place of that of the C library, also for libdynmesh. */
void *malloc(size_t size) {
  if (left == 0) return NULL;
  if (left > 0) --left;
  return __libc_malloc(size);
}

static const uint64_t kIds[] = {1, 2, 3, 4}, kEnd = 3;
static const double kPlaces[] = {0.25, 0.25, 0.75, 0.25, 0.5, 0.75};

static int fill(dynmesh_batch *batch, dynmesh_error *error) {
  const int code = dynmesh_add_points(batch, DYNMESH_ADD, dynmesh_u64s(kIds, 3),
                                      dynmesh_f64s(kPlaces, 3, 2), error);
  return code ? code
              : dynmesh_add_polygon(batch, DYNMESH_ADD, 9, dynmesh_u64s(kIds, 3),
                                    dynmesh_u64s(&kEnd, 1), error);
}

int main(void) {
  dynmesh_error error;
  dynmesh_options options;
  dynmesh_mesh *mesh = NULL;
  dynmesh_batch *batch = NULL;
  int code = 1;
  dynmesh_default_options(2, &options);

  left = 0;
  EXPECT(dynmesh_batch_new(&batch, &error) == DYNMESH_RESOURCE_EXHAUSTED && batch == NULL);
  EXPECT(error.code == DYNMESH_RESOURCE_EXHAUSTED && error.edit == -1 && error.message[0] != 0);
  EXPECT(dynmesh_batch_new(&batch, NULL) == DYNMESH_RESOURCE_EXHAUSTED);
  left = -1;
  EXPECT(!dynmesh_batch_new(&batch, &error));

  /* A column that says that it has more rows than there is memory: all of them are row 0. */
  dynmesh_column endless = {kIds, (size_t)1 << 58, 0, 1, DYNMESH_U64};
  EXPECT(dynmesh_add_polygon(batch, DYNMESH_ADD, 9, endless, dynmesh_u64s(&kEnd, 1), &error) ==
         DYNMESH_RESOURCE_EXHAUSTED);
  EXPECT(dynmesh_batch_count(batch) == 0);

  /* Each allocation in turn is the first one that fails. */
  for (long most = 0; code != DYNMESH_OK; ++most) {
    left = most;
    code = fill(batch, &error);
    left = -1;
    EXPECT(code == DYNMESH_OK || code == DYNMESH_RESOURCE_EXHAUSTED);
    if (code) dynmesh_batch_clear(batch);
  }
  EXPECT(dynmesh_batch_count(batch) == 4);

  /* The first allocation of a call fails. Later ones may be those of Abseil's tables, which need them. */
  char before[33], after[33];
  left = 0;
  code = dynmesh_open(&options, &mesh, &error);
  left = -1;
  EXPECT(code == DYNMESH_RESOURCE_EXHAUSTED && mesh == NULL);
  EXPECT(!dynmesh_open(&options, &mesh, &error));
  dynmesh_hash(mesh, before);
  left = 0;
  code = dynmesh_apply(mesh, batch, NULL, &error);
  left = -1;
  EXPECT(code == DYNMESH_RESOURCE_EXHAUSTED && error.message[0] != 0);
  EXPECT(dynmesh_apply(mesh, batch, NULL, &error) == DYNMESH_DATA_LOSS);
  dynmesh_hash(mesh, after);
  EXPECT(strcmp(before, after) == 0);
  dynmesh_close(mesh);
  dynmesh_batch_free(batch);
  return failures != 0;
}
