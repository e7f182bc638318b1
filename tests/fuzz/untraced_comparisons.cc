// For targets that compute more than they parse: libFuzzer's records of compared numbers are
// dropped. Those of a mesher are coordinates, of which it learns nothing, and they take half of the
// time. The linker puts these functions in the place of libFuzzer's (--wrap, see CMakeLists.txt).
#include <cstdint>

extern "C" {
void __wrap___sanitizer_cov_trace_cmp4(std::uint32_t, std::uint32_t) {}
void __wrap___sanitizer_cov_trace_cmp8(std::uint64_t, std::uint64_t) {}
void __wrap___sanitizer_cov_trace_const_cmp4(std::uint32_t, std::uint32_t) {}
void __wrap___sanitizer_cov_trace_const_cmp8(std::uint64_t, std::uint64_t) {}
}
