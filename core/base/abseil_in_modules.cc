// Three sources of Abseil anew, for shared objects that have Abseil inside: an extension module of
// Python in a wheel, the library of the C interface.
//
// Debian's archives of Abseil are compiled for programs. A linker accepts them in a shared object,
// but for variables that a thread has of its own, and for `stderr`. These are in three of their
// sources, of which nothing is linked if an object has their names already: this one. Its variables
// are compiled for shared objects. `stderr` is found by another name (-Wl,--wrap=stderr).
//
// What it does not do: no sampling of cords, which nothing here switches on, and no order of
// insertion by chance in hash tables (only code without NDEBUG requests it).
//
// For one release of Abseil: another one declares other functions. Not a part of the library.
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <thread>

#include "absl/base/config.h"
#include "absl/base/internal/sysinfo.h"
#include "absl/container/internal/raw_hash_set.h"
#include "absl/strings/internal/cordz_functions.h"

static_assert(ABSL_LTS_RELEASE_VERSION == 20220623);

extern "C" {
// Of the linker: the name of that variable in the C library, and the one that objects get for it.
extern FILE* __real_stderr;     // NOLINT(bugprone-reserved-identifier)
FILE* __wrap_stderr = nullptr;  // NOLINT(bugprone-reserved-identifier)
}

namespace {
struct Stderr {
  Stderr() { __wrap_stderr = __real_stderr; }
} set_stderr;
}  // namespace

namespace absl {
ABSL_NAMESPACE_BEGIN

namespace base_internal {  // sysinfo.cc

int NumCPUs() {
  static const int count = static_cast<int>(std::thread::hardware_concurrency());
  return count;
}

// As Abseil where it finds no frequency. Only figures of how long locks waited are made with it.
double NominalCPUFrequency() { return 1; }

pid_t GetTID() { return static_cast<pid_t>(syscall(SYS_gettid)); }

pid_t GetCachedTID() {
  static thread_local const pid_t id = GetTID();
  return id;
}

}  // namespace base_internal

namespace cord_internal {  // cordz_functions.cc

thread_local std::int64_t cordz_next_sample = std::numeric_limits<std::int64_t>::max();

std::int32_t get_cordz_mean_interval() { return std::numeric_limits<std::int32_t>::max(); }

bool cordz_should_profile_slow() {
  cordz_next_sample = std::numeric_limits<std::int64_t>::max();
  return false;
}

}  // namespace cord_internal

namespace container_internal {  // raw_hash_set.cc

alignas(16) extern const ctrl_t kEmptyGroup[16] = {
    ctrl_t::kSentinel, ctrl_t::kEmpty, ctrl_t::kEmpty, ctrl_t::kEmpty,
    ctrl_t::kEmpty,    ctrl_t::kEmpty, ctrl_t::kEmpty, ctrl_t::kEmpty,
    ctrl_t::kEmpty,    ctrl_t::kEmpty, ctrl_t::kEmpty, ctrl_t::kEmpty,
    ctrl_t::kEmpty,    ctrl_t::kEmpty, ctrl_t::kEmpty, ctrl_t::kEmpty};

template FindInfo find_first_non_full(const ctrl_t*, size_t, size_t);

bool ShouldInsertBackwards(size_t, const ctrl_t*) { return false; }

// Its bytes, the sentinel among them, then a copy of the first ones: so groups may reach beyond the
// end.
void ConvertDeletedToEmptyAndFullToDeleted(ctrl_t* ctrl, size_t capacity) {
  for (size_t i = 0; i < capacity; i += Group::kWidth) {
    Group(ctrl + i).ConvertSpecialToEmptyAndFullToDeleted(ctrl + i);
  }
  std::memcpy(ctrl + capacity + 1, ctrl, Group::kWidth - 1);
  ctrl[capacity] = ctrl_t::kSentinel;
}

void HashTableSizeOverflow() {
  std::fputs("dynmesh: a hash table is too large\n", stderr);
  std::abort();
}

}  // namespace container_internal
ABSL_NAMESPACE_END
}  // namespace absl
