// Same behaviour as std::vector, at sizes below and above those of huge pages.
#include "core/base/large_vector.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace dynmesh {
namespace {

static_assert(std::contiguous_iterator<decltype(LargeVector<int>().begin())>);

template <class T>
void ExpectSame(const LargeVector<T>& got, const std::vector<T>& wanted) {
  ASSERT_EQ(got.size(), wanted.size());
  ASSERT_EQ(got.empty(), wanted.empty());
  ASSERT_GE(got.capacity(), got.size());
  ASSERT_TRUE(std::equal(got.begin(), got.end(), wanted.begin()));
}

// `make` makes a value of a number.
template <class T, class Make>
void DoTheSame(std::uint64_t seed, int steps, std::size_t most, Make make) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  LargeVector<T> got;
  std::vector<T> wanted;
  for (int step = 0; step < steps; ++step) {
    const std::size_t size = random() % most;
    const T value = make(static_cast<int>(random() % 1000));
    switch (random() % 9) {
      case 0:
        got.resize(size), wanted.resize(size);
        break;
      case 1:
        got.resize(size, value), wanted.resize(size, value);
        break;
      case 2:
        got.reserve(size), wanted.reserve(size);
        break;
      case 3:
        got.assign(size / 4, value), wanted.assign(size / 4, value);
        break;
      case 4:
        if (random() % 4 == 0) got.clear(), wanted.clear();
        break;
      case 5: {
        LargeVector<T> copy = got;
        got.clear();
        got = std::move(copy);
        break;
      }
      case 6:
        if (!wanted.empty()) got.pop_back(), wanted.pop_back();
        break;
      case 7:
        if (!wanted.empty()) {
          const std::size_t i = random() % wanted.size();
          ASSERT_TRUE(got[i] == wanted[i]);
          got[i] = value, wanted[i] = value;
        }
        break;
      default:
        for (std::size_t i = 0; i < size / 8; ++i) {
          got.push_back(value), wanted.push_back(value);
          got.emplace_back(make(static_cast<int>(i))), wanted.push_back(make(static_cast<int>(i)));
        }
    }
    ExpectSame(got, wanted);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(LargeVector, DoesWhatStdVectorDoes) {
  using Wide = std::array<std::uint64_t, 5>;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    DoTheSame<int>(seed, 300, 300, [](int i) { return i; });
    DoTheSame<std::string>(seed, 300, 300, [](int i) { return std::string(i % 50, 'a'); });
  }
  // Up to 12 MiB.
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    DoTheSame<int>(seed, 60, 3'000'000, [](int i) { return i; });
    DoTheSame<Wide>(seed, 60, 300'000, [](int i) { return Wide{1, 2, std::uint64_t(i), 4, 5}; });
  }
  DoTheSame<std::string>(4, 20, 300'000, [](int i) { return std::string(i % 50, 'a'); });
}

TEST(LargeVector, HoldsWhatCanOnlyBeMoved) {
  LargeVector<std::unique_ptr<int>> owners;
  for (int i = 0; i < 1'000; ++i) owners.push_back(std::make_unique<int>(i));
  owners.resize(2'000);
  for (int i = 0; i < 1'000; ++i) EXPECT_EQ(*owners[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(owners.back(), nullptr);
}

TEST(LargeVector, TakesItsOwnElementsWhileItGrows) {
  LargeVector<std::string> words = {std::string(40, 'x')};
  for (int i = 0; i < 1'000; ++i) words.push_back(words.front());
  for (const std::string& word : words) EXPECT_EQ(word, std::string(40, 'x'));
  words.resize(10'000, words.front());
  EXPECT_EQ(words.back(), std::string(40, 'x'));
  words.assign(3, words.back());
  EXPECT_EQ(words.front(), std::string(40, 'x'));
}

// In place, and moved elsewhere, with any memory behind it.
TEST(LargeVector, GrowsOverAndOver) {
  std::vector<LargeVector<std::uint64_t>> side_by_side(6);
  constexpr std::uint64_t kEach = 4'000'000;  // 32 MB
  for (std::uint64_t i = 0; i < kEach; ++i) {
    for (std::uint64_t k = 0; k < side_by_side.size(); ++k) side_by_side[k].push_back(7 * i + k);
  }
  for (std::uint64_t k = 0; k < side_by_side.size(); ++k) {
    ASSERT_EQ(side_by_side[k].size(), kEach);
    std::uint64_t wrong = 0;
    for (std::uint64_t i = 0; i < kEach; ++i) wrong += side_by_side[k][i] != 7 * i + k;
    EXPECT_EQ(wrong, 0u);
    if (huge_pages::AreFor(8 * kEach)) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(side_by_side[k].data()) % huge_pages::kPage, 0u);
    }
  }
}

}  // namespace
}  // namespace dynmesh
