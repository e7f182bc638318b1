/* Counts what does not hold, and says where. For programs of one source. */
#ifndef DYNMESH_TESTS_CLIENT_C_EXPECT_H_
#define DYNMESH_TESTS_CLIENT_C_EXPECT_H_

#include <stdio.h>

#define EXPECT(holds)                                          \
  do {                                                         \
    if (!(holds)) {                                            \
      fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #holds); \
      ++failures;                                              \
    }                                                          \
  } while (0)

static int failures = 0;

#endif  /* DYNMESH_TESTS_CLIENT_C_EXPECT_H_ */
