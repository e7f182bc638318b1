// Text in memory, made of the same parts as that of a FileWriter: numbers are the shortest that
// read back bit for bit. For rows of large files: no check or copy a number. Thread-compatible.
#ifndef DYNMESH_CORE_IO_COMMON_TEXT_BLOCK_H_
#define DYNMESH_CORE_IO_COMMON_TEXT_BLOCK_H_

#include <algorithm>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string_view>

namespace dynmesh::io {

class TextBlock {
 public:
  std::string_view text() const { return {data_.get(), size_}; }
  void Clear() { size_ = 0; }  // keeps the memory

  TextBlock& operator<<(std::string_view text) {
    std::copy(text.begin(), text.end(), Room(text.size()));
    size_ += text.size();
    return *this;
  }
  TextBlock& operator<<(char c) {
    *Room(1) = c;
    ++size_;
    return *this;
  }
  template <std::integral T>
  TextBlock& operator<<(T value) {
    return Put(value);
  }
  TextBlock& operator<<(double value) { return Put(value); }

 private:
  static constexpr std::size_t kLongestNumber = 32;

  template <class T>
  TextBlock& Put(T value) {
    char* const begin = Room(kLongestNumber);
    const char* const end = std::to_chars(begin, begin + kLongestNumber, value).ptr;
    size_ += static_cast<std::size_t>(end - begin);
    return *this;
  }
  char* Room(std::size_t bytes) {
    if (capacity_ - size_ < bytes) Grow(bytes);
    return data_.get() + size_;
  }
  void Grow(std::size_t bytes) {
    const std::size_t capacity = std::max(2 * capacity_, size_ + bytes + (std::size_t{1} << 12));
    auto data = std::make_unique_for_overwrite<char[]>(capacity);
    std::copy_n(data_.get(), size_, data.get());
    data_ = std::move(data);
    capacity_ = capacity;
  }

  std::unique_ptr<char[]> data_;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_TEXT_BLOCK_H_
