/* dynmesh in C11: a dynamic mesh in this process. Features in, as columns; arrays by slot out.
 *
 *   dynmesh_options options;
 *   dynmesh_error error;
 *   dynmesh_mesh *mesh;
 *   dynmesh_batch *batch;
 *   dynmesh_default_options(2, &options);
 *   if (dynmesh_open(&options, &mesh, &error)) return puts(error.message), 1;
 *   dynmesh_batch_new(&batch, &error);
 *   uint64_t id = 1;
 *   double place[2] = {0.5, 0.5};
 *   dynmesh_add_points(batch, DYNMESH_ADD, dynmesh_u64s(&id, 1), dynmesh_f64s(place, 1, 2), &error);
 *   if (dynmesh_apply(mesh, batch, NULL, &error)) puts(error.message);
 *
 * Errors. A function that may fail returns a code, DYNMESH_OK or one of the others, and describes it
 * in `error`, which is the caller's and may be NULL. A call that fails has changed nothing, unless it
 * says so. No exception leaves the library. If memory runs out a call returns RESOURCE_EXHAUSTED; but
 * where a hash table of Abseil grows at that moment, the process may end.
 *
 * Memory. What `..._new`, `dynmesh_open`, `dynmesh_read` and `dynmesh_part_new` make is freed by the
 * function that they name, which takes NULL, too. Nothing else changes hands: columns that come in
 * are read during the call, columns that go out are the library's, and end as they say.
 *
 * Threads. Objects do not know each other, but for what a call is given. Calls with one object exclude
 * each other if one of them is not only reading: functions that take a `const` object read.
 * Different objects may be used by different threads at the same time.
 *
 * Versions. Structures with a member `size` grow at their end, by whole members. `dynmesh_default_...`
 * sets it to the size that the program was compiled with. The library writes no more, and members that
 * are behind have their defaults; members that it does not know are set to 0 and not read. Values of
 * enumerations stay. libdynmesh.so.0 is compatible with programs that were compiled for an earlier
 * libdynmesh.so.0. Languages that do not compile this header call `dynmesh_fill_...` with their size.
 */
#ifndef DYNMESH_H_
#define DYNMESH_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this header; dynmesh_version() has that of the library. */
#define DYNMESH_C_VERSION_MAJOR 0
#define DYNMESH_C_VERSION_MINOR 1

/* "MAJOR.MINOR.PATCH" of the library. */
const char *dynmesh_version(void);

/* ---- errors */

enum {
  DYNMESH_OK = 0,
  DYNMESH_CANCELLED = 1,            /* by dynmesh_apply_options.interrupted */
  DYNMESH_INTERNAL = 2,             /* a fault of the library */
  DYNMESH_INVALID_ARGUMENT = 3,     /* malformed by itself */
  DYNMESH_NOT_FOUND = 5,            /* a feature or file that is not there */
  DYNMESH_ALREADY_EXISTS = 6,       /* an id that is in use */
  DYNMESH_RESOURCE_EXHAUSTED = 8,   /* a limit, or memory */
  DYNMESH_FAILED_PRECONDITION = 9,  /* features conflict, or a call is out of order */
  DYNMESH_OUT_OF_RANGE = 11,
  DYNMESH_UNIMPLEMENTED = 12,
  DYNMESH_UNAVAILABLE = 14, /* a file cannot be written */
  DYNMESH_DATA_LOSS = 15    /* an edit before was broken off: the mesh can be read only */
};

/* Texts end with 0 and are cut to fit. */
typedef struct dynmesh_error {
  int32_t code;
  int32_t feature_count;  /* of `features` */
  int64_t edit;           /* number of the batch's edit to blame, from 0; -1: none */
  uint64_t features[8];   /* those involved, the one to blame first */
  char reason[32];        /* as "POINT_IN_USE", stable; empty: none */
  char message[1024];     /* says what to do */
} dynmesh_error;

/* ---- columns */

enum { DYNMESH_F64 = 1, DYNMESH_I32 = 2, DYNMESH_U64 = 3, DYNMESH_U8 = 4, DYNMESH_I64 = 5 };

/* `rows` rows of `width` numbers each, `stride` bytes from row to row. The numbers of a row lie side
 * by side. `data` and `stride` of a column that comes in are multiples of 8 bytes; `stride` may be
 * negative, or 0. A column without rows may have NULL. */
typedef struct dynmesh_column {
  const void *data;
  size_t rows;
  ptrdiff_t stride;
  int32_t width;
  int32_t type; /* DYNMESH_F64, ... */
} dynmesh_column;

static inline dynmesh_column dynmesh_f64s(const double *data, size_t rows, int32_t width) {
  dynmesh_column c = {data, rows, (ptrdiff_t)(sizeof(double) * (size_t)width), width, DYNMESH_F64};
  return c;
}
static inline dynmesh_column dynmesh_u64s(const uint64_t *data, size_t rows) {
  dynmesh_column c = {data, rows, sizeof(uint64_t), 1, DYNMESH_U64};
  return c;
}
/* `rows` pairs: the ends of segments. */
static inline dynmesh_column dynmesh_u64_pairs(const uint64_t *data, size_t rows) {
  dynmesh_column c = {data, rows, 2 * sizeof(uint64_t), 2, DYNMESH_U64};
  return c;
}

/* ---- meshes */

enum { DYNMESH_DELAUNAY = 1, DYNMESH_QUADTREE = 2, DYNMESH_TRIANGULATION = 3 };
enum { DYNMESH_EDGE = 1, DYNMESH_THESIS = 2 };

/* What a mesh is made with; members as in core/include/dynmesh/options.h. */
typedef struct dynmesh_options {
  size_t size;         /* of this structure */
  int32_t dimension;   /* 2 or 3 */
  int32_t kind;        /* DYNMESH_DELAUNAY, ... */
  int32_t criterion;   /* DYNMESH_EDGE, ... */
  int32_t reserved;    /* 0 */
  double low[3];       /* the box of the features */
  double high[3];
  double quality;      /* the largest circumradius / shortest edge */
  double max_edge;     /* no edge in the box is longer than sqrt 2 times this; 0: no bound */
  double min_dihedral; /* 3D, in degrees */
  uint64_t max_vertices;
} dynmesh_options;

/* Those of a Delaunay mesh of the unit square or cube, in a structure of `size` bytes. */
void dynmesh_fill_options(int32_t dimension, dynmesh_options *options, size_t size);
static inline void dynmesh_default_options(int32_t dimension, dynmesh_options *options) {
  dynmesh_fill_options(dimension, options, sizeof *options);
}

typedef struct dynmesh_mesh dynmesh_mesh;

/* A mesh of the bare box, at revision 0, freed by dynmesh_close. INVALID_ARGUMENT for bad options. */
int dynmesh_open(const dynmesh_options *options, dynmesh_mesh **mesh, dynmesh_error *error);
void dynmesh_close(dynmesh_mesh *mesh);

/* The number of batches applied that changed something. O(1). */
uint64_t dynmesh_revision(const dynmesh_mesh *mesh);
/* 32 hexadecimal digits and a 0: equal for equal meshes, as all interfaces of dynmesh have it. O(1). */
void dynmesh_hash(const dynmesh_mesh *mesh, char hash[33]);

enum {
  DYNMESH_VERTICES = 1,     /* in use */
  DYNMESH_CELLS_IN_USE = 2, /* triangles, in 3D tetrahedra */
  DYNMESH_VERTEX_SLOTS = 3, /* rows of columns of vertices */
  DYNMESH_CELL_SLOTS = 4,   /* rows of columns of cells */
  DYNMESH_FEATURES = 5
};
/* One of these counts. O(1); 0 for another number. */
uint64_t dynmesh_count(const dynmesh_mesh *mesh, int which);

/* ---- batches of edits */

typedef struct dynmesh_batch dynmesh_batch;

enum { DYNMESH_ADD = 1, DYNMESH_SET = 2 }; /* a new feature, or in place of the one with that id */

/* An empty batch, freed by dynmesh_batch_free. It may be applied more than once. */
int dynmesh_batch_new(dynmesh_batch **batch, dynmesh_error *error);
void dynmesh_batch_free(dynmesh_batch *batch);
void dynmesh_batch_clear(dynmesh_batch *batch);
/* Edits so far. */
size_t dynmesh_batch_count(const dynmesh_batch *batch);

/* Each appends one edit a row, O(rows). INVALID_ARGUMENT if columns have other types, widths or numbers
 * of rows than stated; what they say is judged by dynmesh_apply. `ids` are u64, and `action` is
 * DYNMESH_ADD or DYNMESH_SET. */

/* Points at `places`: f64, 2 or 3 a row. */
int dynmesh_add_points(dynmesh_batch *batch, int action, dynmesh_column ids, dynmesh_column places,
                       dynmesh_error *error);
/* Segments between points: `ends` are u64, 2 a row. */
int dynmesh_add_segments(dynmesh_batch *batch, int action, dynmesh_column ids, dynmesh_column ends,
                         dynmesh_error *error);
/* One polygon. `corners`: u64, the points of all its rings, one after the other; `ring_ends`: u64, for
 * each ring how many corners it and those before have. */
int dynmesh_add_polygon(dynmesh_batch *batch, int action, uint64_t id, dynmesh_column corners,
                        dynmesh_column ring_ends, dynmesh_error *error);
/* Target lengths within `radii` of `places`: f64 columns; `radii` may have no rows: at the places. */
int dynmesh_add_sizes(dynmesh_batch *batch, int action, dynmesh_column ids, dynmesh_column places,
                      dynmesh_column radii, dynmesh_column targets, dynmesh_error *error);
int dynmesh_move_points(dynmesh_batch *batch, dynmesh_column ids, dynmesh_column places,
                        dynmesh_error *error);
int dynmesh_remove(dynmesh_batch *batch, dynmesh_column ids, dynmesh_error *error);
/* The label of a feature; 0 and "" take it away. */
int dynmesh_set_label(dynmesh_batch *batch, uint64_t id, int64_t marker, const char *name,
                      dynmesh_error *error);

typedef struct dynmesh_apply_options {
  size_t size;                         /* of this structure */
  int (*interrupted)(void *context);   /* true ends the batch: CANCELLED. Called every few microseconds, on
                                          the thread of the call; must not use the mesh, and must return.
                                          NULL: never */
  void *context;                       /* its argument */
  uint64_t max_operations;             /* more end the batch: RESOURCE_EXHAUSTED; 0: no limit */
} dynmesh_apply_options;
void dynmesh_fill_apply_options(dynmesh_apply_options *options, size_t size);
static inline void dynmesh_default_apply_options(dynmesh_apply_options *options) {
  dynmesh_fill_apply_options(options, sizeof *options);
}

/* Makes the next revision: all edits or none. An empty batch makes none. `options` may be NULL. Time is
 * that of the change, not of the mesh. Columns of the mesh that were handed out end.
 *
 * On an error the mesh is as it was. Only if memory runs out, or by a fault of the library (INTERNAL),
 * it is then read only: later calls return DATA_LOSS. */
int dynmesh_apply(dynmesh_mesh *mesh, const dynmesh_batch *batch, const dynmesh_apply_options *options,
                  dynmesh_error *error);

/* ---- arrays by slot
 *
 * A vertex or cell keeps its row, its slot, while it exists; so a program's arrays with a row a slot
 * need no renumbering, only more rows at their end (dynmesh_count). */

enum {
  /* By vertex. */
  DYNMESH_POINTS = 1,     /* f64, dimension a row; of free slots the last ones */
  DYNMESH_VERTEX_IDS = 2, /* u64; 0: the slot is free */
  DYNMESH_OWNERS = 3,     /* u64: the feature that the vertex lies on, 0: none, 2^64 - 1: the box */
  DYNMESH_ON = 4,         /* u8: 0 on a point, 1 on a segment, 2 in 3D on a polygon, dimension: free */
  /* By cell. */
  DYNMESH_CELLS = 5,      /* i32, dimension + 1 slots of vertices a row, positively oriented; -1: free */
  DYNMESH_NEIGHBOURS = 6, /* i32: the cell opposite to each corner; -1: none */
  DYNMESH_REGIONS = 7,    /* u64: the polygon, in 3D the closed surface, that the cell lies in; 0: none;
                             of several a number from 2^63 on */
  /* By subsegment, in 3D also by subfacet. */
  DYNMESH_SUBSEGMENTS = 8, /* i32, 2 slots of vertices a row; -1: free */
  DYNMESH_SUBSEGMENT_OWNERS = 9,
  DYNMESH_SUBFACETS = 10, /* i32, 3 a row */
  DYNMESH_SUBFACET_OWNERS = 11
};
/* A column of the mesh, O(1). It ends with the next dynmesh_apply or dynmesh_close. */
int dynmesh_array(const dynmesh_mesh *mesh, int which, dynmesh_column *column, dynmesh_error *error);

enum {
  DYNMESH_REMOVED_VERTICES = 1, /* i32: slots that are free now; their points stay for a while */
  DYNMESH_ADDED_VERTICES = 2,   /* i32: slots that are filled now */
  DYNMESH_REMOVED_CELLS = 3,    /* i32 */
  DYNMESH_REMOVED_CORNERS = 4,  /* i32, dimension + 1 slots of vertices a row: of the removed cells */
  DYNMESH_REMOVED_REGIONS = 5,  /* u64: of the removed cells */
  DYNMESH_ADDED_CELLS = 6,      /* i32 */
  DYNMESH_RELABELLED_CELLS = 7, /* i32: in both meshes, in another region now */
  DYNMESH_FORMER_REGIONS = 8    /* u64: of these, before */
};
/* The diff: a column of what the last dynmesh_apply without an error has changed; after an empty batch
 * it has no rows. O(1). A slot may be in a removed and an added column. It ends with the next
 * dynmesh_apply or dynmesh_close. */
int dynmesh_diff(const dynmesh_mesh *mesh, int which, dynmesh_column *column, dynmesh_error *error);

/* For each of `places` (f64, dimension a row) the slot of a cell that contains it, in `cells`, which
 * has room for as many; -1 outside. Not of a quadtree: UNIMPLEMENTED. Expected O(lg mesh) each. */
int dynmesh_locate(const dynmesh_mesh *mesh, dynmesh_column places, int32_t *cells,
                   dynmesh_error *error);

/* ---- fields */

enum {
  DYNMESH_P0 = 1,           /* a mean a cell; first order, within its range */
  DYNMESH_P0_LINEAR = 2,    /* the same, second order */
  DYNMESH_P1 = 3,           /* a value a vertex */
  DYNMESH_DG1 = 4,          /* a value a corner of each cell */
  DYNMESH_DUAL = 5,         /* a mean a median-dual cell, by vertex */
  DYNMESH_DUAL_CORNERS = 6, /* the same, by corner of each cell */
  DYNMESH_OVERLAP = 7       /* the row of the cell with the largest overlap */
};

/* As core/include/dynmesh/transfer.h. */
typedef struct dynmesh_field {
  size_t size;        /* of this structure */
  int32_t kind;       /* DYNMESH_P0, ... */
  int32_t components; /* numbers a row; of kinds by corner, a corner */
  int32_t rings;      /* P1: how far the projection reaches */
  int32_t bounded;    /* each component stays within its old values */
} dynmesh_field;
/* One component, P1, one ring, not bounded. */
void dynmesh_fill_field(dynmesh_field *field, size_t size);
static inline void dynmesh_default_field(dynmesh_field *field) {
  dynmesh_fill_field(field, sizeof *field);
}

/* Carries the field in `values` across the last dynmesh_apply without an error, in place and
 * conservatively: a row of each slot, of vertices or of cells; those behind the former end count as
 * nothing. Values outside the patch stay, to the bit; after an empty batch all do. `values` has `rows`
 * rows (dynmesh_count), `stride` bytes apart: a multiple of 8 bytes, and not less than a row. Time is
 * that of the change if the rows lie side by side, else O(rows), since it works on a copy; what fields
 * have in common is computed once for each revision. FAILED_PRECONDITION before the first batch, and if nothing was there
 * before. */
int dynmesh_carry(dynmesh_mesh *mesh, const dynmesh_field *field, double *values, size_t rows,
                  ptrdiff_t stride, dynmesh_error *error);

/* ---- the part in polygons: the mesh reaches far beyond its features */

typedef struct dynmesh_part dynmesh_part;

/* Which cells: those in one of `polygons` (u64) and in none of `without`, or with `inside` in any one;
 * opened along the segments and polygons `open`, as cracks are. */
typedef struct dynmesh_choice {
  size_t size; /* of this structure */
  dynmesh_column polygons;
  dynmesh_column without;
  dynmesh_column open;
  int32_t inside;
  int32_t reserved; /* 0 */
} dynmesh_choice;
/* All that polygons enclose. */
void dynmesh_fill_choice(dynmesh_choice *choice, size_t size);
static inline void dynmesh_default_choice(dynmesh_choice *choice) {
  dynmesh_fill_choice(choice, sizeof *choice);
}

/* A part, freed by dynmesh_part_free. O(mesh). It needs the mesh for the calls that take it, only. */
int dynmesh_part_new(const dynmesh_mesh *mesh, const dynmesh_choice *choice, dynmesh_part **part,
                     dynmesh_error *error);
void dynmesh_part_free(dynmesh_part *part);
/* Follows the mesh. O(change) after each batch; O(mesh) if a batch was left out. Its columns end. */
int dynmesh_part_update(dynmesh_part *part, const dynmesh_mesh *mesh, dynmesh_error *error);

enum {
  DYNMESH_PART_POINTS = 1,       /* f64, dimension a row */
  DYNMESH_PART_VERTEX_SLOTS = 2, /* i32: of each in the mesh */
  DYNMESH_PART_CELLS = 3,        /* i32: numbers of vertices, dimension + 1 a row */
  DYNMESH_PART_CELL_SLOTS = 4,
  DYNMESH_PART_REGIONS = 5,      /* u64, by cell */
  DYNMESH_PART_FACETS = 6,       /* i32: border, segments and polygons; dimension a row */
  DYNMESH_PART_FACET_OWNERS = 7, /* u64 */
  DYNMESH_PART_FACET_CELLS = 8   /* i32: slots of the cells beside, 2 a row; -1: none */
};
/* A column of the part, without gaps. O(1). It ends with dynmesh_part_update or dynmesh_part_free. */
int dynmesh_part_array(const dynmesh_part *part, int which, dynmesh_column *column,
                       dynmesh_error *error);

/* ---- files */

typedef struct dynmesh_input dynmesh_input;

enum {
  DYNMESH_MERGE_COPLANAR = 1, /* 3D: faces in one plane are joined */
  DYNMESH_MAP_POLYGONS = 2,   /* rings of a map are polygons, not segments */
  DYNMESH_REFINE = 4,         /* the file is a mesh to be refined */
  DYNMESH_KEEP_FACETS = 8     /* of a surface: faces stay as they are */
};
/* The content of a file, by its extension, freed by dynmesh_input_free: formats and errors of ReadInput
 * in core/include/dynmesh/files.h. `flags`: a sum of the above. */
int dynmesh_read(const char *path, int flags, dynmesh_input **input, dynmesh_error *error);
void dynmesh_input_free(dynmesh_input *input);
/* Options for a mesh of it, in a structure of `size` bytes. */
void dynmesh_input_fill_options(const dynmesh_input *input, dynmesh_options *options, size_t size);
static inline void dynmesh_input_options(const dynmesh_input *input, dynmesh_options *options) {
  dynmesh_input_fill_options(input, options, sizeof *options);
}
/* A batch that adds all its features; it ends with the input. */
const dynmesh_batch *dynmesh_input_batch(const dynmesh_input *input);

enum {
  DYNMESH_ORDER_2 = 1,        /* elements with a node in the middle of each edge */
  DYNMESH_FROM_ZERO = 2,      /* a .node is numbered from 0 */
  DYNMESH_BINARY = 4,         /* a .msh has bytes */
  DYNMESH_INPUT_MARKERS = 8   /* markers are those of labels */
};
/* Writes the mesh, or its part if that is not NULL, by the extension of `path`: formats and errors of
 * WriteMesh in core/include/dynmesh/files.h. O(n lg n). */
int dynmesh_write(const dynmesh_mesh *mesh, const dynmesh_part *part, const char *path, int flags,
                  dynmesh_error *error);

#ifdef __cplusplus
}
#endif

#endif /* DYNMESH_H_ */
