// A std::vector for arrays that may become very large: on huge pages (huge_pages.h). An array of
// trivially copyable elements grows without a copy, so no push_back takes long.
//
// Members do what those of std::vector do. Below 4 MiB it is an ordinary array. As thread-safe as
// std::vector.
#ifndef DYNMESH_CORE_BASE_LARGE_VECTOR_H_
#define DYNMESH_CORE_BASE_LARGE_VECTOR_H_

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

#include "core/base/huge_pages.h"

namespace dynmesh {

template <class T>
class LargeVector {
  static_assert(std::is_nothrow_move_constructible_v<T>);

 public:
  using value_type = T;

  LargeVector() = default;
  explicit LargeVector(std::size_t count) { resize(count); }
  LargeVector(std::size_t count, const T& value) { resize(count, value); }
  LargeVector(std::initializer_list<T> values) {
    reserve(values.size());
    for (const T& value : values) push_back(value);
  }
  LargeVector(const LargeVector& other) {
    reserve(other.size_);
    std::uninitialized_copy_n(other.data_, other.size_, data_);
    size_ = other.size_;
  }
  LargeVector(LargeVector&& other) noexcept { swap(other); }
  LargeVector& operator=(LargeVector other) noexcept {
    swap(other);
    return *this;
  }
  ~LargeVector() {
    clear();
    Deallocate(data_, capacity_);
  }

  void swap(LargeVector& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  T& operator[](std::size_t i) {
    Require(i < size_);
    return data_[i];
  }
  const T& operator[](std::size_t i) const {
    Require(i < size_);
    return data_[i];
  }
  T& front() { return (*this)[0]; }
  const T& front() const { return (*this)[0]; }
  T& back() { return (*this)[size_ - 1]; }
  const T& back() const { return (*this)[size_ - 1]; }

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }

  void reserve(std::size_t capacity) {
    if (capacity > capacity_) Reallocate(capacity);
  }
  void clear() { Shrink(0); }
  void resize(std::size_t size) {
    if (size <= size_) return Shrink(size);
    MakeRoom(size);
    std::uninitialized_value_construct(data_ + size_, data_ + size);
    size_ = size;
  }
  void resize(std::size_t size, const T& value) {
    if (size <= size_) return Shrink(size);
    const T copy = value;  // `value` may be an element
    MakeRoom(size);
    std::uninitialized_fill(data_ + size_, data_ + size, copy);
    size_ = size;
  }
  void assign(std::size_t size, const T& value) {
    const T copy = value;
    clear();
    resize(size, copy);
  }
  void push_back(const T& value) { emplace_back(value); }
  void push_back(T&& value) { emplace_back(std::move(value)); }
  template <class... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    if (size_ == capacity_) {
      T made(std::forward<Arguments>(arguments)...);  // arguments may refer to elements
      MakeRoom(size_ + 1);
      return *new (data_ + size_++) T(std::move(made));
    }
    return *new (data_ + size_++) T(std::forward<Arguments>(arguments)...);
  }
  void pop_back() {
    Require(size_ > 0);
    Shrink(size_ - 1);
  }

 private:
  static constexpr std::size_t kFirst = std::max<std::size_t>(1, 64 / sizeof(T));

  // Like the containers of the standard library with assertions on.
  static void Require([[maybe_unused]] bool holds) {
#ifdef _GLIBCXX_ASSERTIONS
    if (!holds) __builtin_trap();
#endif
  }
  static T* Allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (huge_pages::AreFor(bytes)) return static_cast<T*>(huge_pages::Map(bytes));
    return static_cast<T*>(::operator new(bytes, std::align_val_t(alignof(T))));
  }
  static void Deallocate(T* block, std::size_t count) {
    if (huge_pages::AreFor(count * sizeof(T))) {
      huge_pages::Unmap(block, count * sizeof(T));
    } else {
      ::operator delete(block, std::align_val_t(alignof(T)));
    }
  }

  void Shrink(std::size_t size) {
    std::destroy(data_ + size, data_ + size_);
    size_ = size;
  }
  void MakeRoom(std::size_t size) {
    if (size > capacity_) Reallocate(std::max({size, 2 * capacity_, kFirst}));
  }
  void Reallocate(std::size_t capacity) {
    if (!GrowInPlace(capacity)) {
      T* const block = Allocate(capacity);
      std::uninitialized_move_n(data_, size_, block);
      std::destroy_n(data_, size_);
      Deallocate(data_, capacity_);
      data_ = block;
    }
    capacity_ = capacity;
  }
  bool GrowInPlace(std::size_t capacity) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      if (!huge_pages::AreFor(capacity_ * sizeof(T))) return false;
      void* const grown = huge_pages::Grow(data_, capacity_ * sizeof(T), capacity * sizeof(T));
      if (grown == nullptr) return false;
      data_ = static_cast<T*>(grown);
      return true;
    }
    return false;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_LARGE_VECTOR_H_
