// The numbers of a `.msh`: in lines of text, or as the bytes of ints, of sizes (64 bits) and of
// doubles, in this machine's order, which the file states.
#ifndef DYNMESH_CORE_IO_MESHES_MSH_NUMBERS_H_
#define DYNMESH_CORE_IO_MESHES_MSH_NUMBERS_H_

#include <cstdint>
#include <cstring>
#include <string_view>

#include "core/io/common/file_writer.h"

namespace dynmesh::io {

// Thread-compatible.
class MshNumbers {
 public:
  // `out` must outlive it.
  MshNumbers(FileWriter& out, bool binary) : out_(out), binary_(binary) {}

  bool binary() const { return binary_; }

  MshNumbers& Int(std::int32_t value) { return Put(value); }
  MshNumbers& Size(std::uint64_t value) { return Put(value); }
  MshNumbers& Real(double value) { return Put(value); }
  // Behind the numbers of a line of text.
  void EndLine() {
    if (!binary_) out_ << '\n';
    begins_ = true;
  }
  // Behind those of a section: text follows.
  void EndSection() {
    if (binary_) out_ << '\n';
  }

 private:
  template <class T>
  MshNumbers& Put(T value) {
    if (binary_) {
      char bytes[sizeof(T)];
      std::memcpy(bytes, &value, sizeof(T));
      out_ << std::string_view(bytes, sizeof(T));
      return *this;
    }
    if (!begins_) out_ << ' ';
    begins_ = false;
    out_ << value;
    return *this;
  }

  FileWriter& out_;
  const bool binary_;
  bool begins_ = true;  // a line
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_MSH_NUMBERS_H_
