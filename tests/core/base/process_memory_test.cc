// What a command and a server ask of the system, counted in page faults and resident memory. Each
// test runs in a process of its own, since a process is set up once.
#include "core/base/process_memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace dynmesh {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

// Sanitizers have an allocator of their own, which keeps what is freed.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

// The part of [NAME] in the system's setting is the one that holds.
bool HugePagesAreGranted() {
  std::string all;
  std::getline(std::ifstream("/sys/kernel/mm/transparent_hugepage/enabled"), all);
  return all.find("[always]") != std::string::npos || all.find("[madvise]") != std::string::npos;
}

std::size_t Faults() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_minflt);
}
std::size_t ResidentBytes() {
  std::size_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

// Blocks of `size` bytes, `total` in all, each byte written to.
std::vector<std::unique_ptr<char[]>> Blocks(std::size_t total, std::size_t size) {
  std::vector<std::unique_ptr<char[]>> blocks;
  for (std::size_t i = 0; i < total / size; ++i) {
    blocks.emplace_back(new char[size]);
    std::memset(blocks.back().get(), 1, size);
  }
  return blocks;
}

// Runs `f` in a child that has been set up for `use`; its result, which is at most 255.
template <class F>
std::size_t InChild(MemoryUse use, F f) {
  const pid_t child = fork();
  if (child == 0) {
    SetUpMemory(use);
    _exit(static_cast<int>(std::min<std::size_t>(f(), 255)));
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << status;
  return static_cast<std::size_t>(WEXITSTATUS(status));
}
// In percent of one fault for each page of 4 KiB.
template <class F>
std::size_t FaultsOf(std::size_t bytes, F f) {
  const std::size_t before = Faults();
  f();
  return (Faults() - before) * 100 / (bytes / 4096);
}

class ProcessMemory : public testing::Test {
 protected:
  void SetUp() override {
    if (!HugePagesAreGranted()) GTEST_SKIP() << "the system grants no huge pages";
  }
};

TEST_F(ProcessMemory, TheHeapOfACommandHasHugePages) {
  EXPECT_LT(InChild(MemoryUse::kCommand,
                    [] { return FaultsOf(128 * kMiB, [] { Blocks(128 * kMiB, 1000); }); }),
            30U);
}

TEST_F(ProcessMemory, WhatACommandFreedItUsesAgain) {
  EXPECT_LT(InChild(MemoryUse::kCommand,
                    [] {
                      Blocks(64 * kMiB, 1000);
                      return FaultsOf(64 * kMiB, [] { Blocks(64 * kMiB, 1000); });
                    }),
            2U);
}

TEST_F(ProcessMemory, SmallPartsOfALargeHeapAreUsedAgain) {
  EXPECT_LT(InChild(MemoryUse::kCommand,
                    [] {
                      const auto kept = Blocks(64 * kMiB, 1000);
                      Blocks(64 * kMiB, 4 * kMiB);
                      const std::size_t before = Faults();
                      Blocks(64 * kMiB, 4 * kMiB);
                      return Faults() - before;
                    }),
            8U);
}

TEST_F(ProcessMemory, LargeBlocksHaveHugePages) {
  for (const MemoryUse use : {MemoryUse::kCommand, MemoryUse::kServer}) {
    EXPECT_LT(
        InChild(use, [] { return FaultsOf(128 * kMiB, [] { Blocks(128 * kMiB, 32 * kMiB); }); }),
        10U);
  }
}

// Megabytes that stay resident of those that were freed.
template <MemoryUse kUse>
std::size_t Kept(std::size_t size) {
  return InChild(kUse, [size] {
    const std::size_t before = ResidentBytes();
    Blocks(128 * kMiB, size);
    const std::size_t after = ResidentBytes();
    return after > before ? (after - before) / kMiB : 0;
  });
}

TEST(ProcessMemoryReturns, LargeBlocksWhenTheyAreFreed) {
  EXPECT_LT(Kept<MemoryUse::kCommand>(4 * kMiB), 8U);
  EXPECT_LT(Kept<MemoryUse::kServer>(4 * kMiB), 8U);
}
TEST(ProcessMemoryReturns, AllThatAServerFreed) { EXPECT_LT(Kept<MemoryUse::kServer>(1000), 8U); }

// A small mesh: its heap has not a huge page that it does not fill.
TEST(ProcessMemoryReturns, NothingIsTakenAhead) {
  EXPECT_LE(InChild(MemoryUse::kCommand,
                    [] {
                      const std::size_t before = ResidentBytes();
                      const auto blocks = Blocks(3 * kMiB, 1000);
                      return (ResidentBytes() - before) / kMiB;
                    }),
            4U);
}

#endif

TEST(OperatorNew, KeepsToTheStandard) {
  SetUpMemory(MemoryUse::kServer);
  for (const std::size_t alignment : {1, 16, 64, 4096}) {
    for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, std::size_t{100}, 3 * kMiB}) {
      void* const block = ::operator new(bytes, std::align_val_t(alignment));
      ASSERT_NE(block, nullptr);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(block) % alignment, 0U);
      std::memset(block, 1, bytes);
      ::operator delete(block, std::align_val_t(alignment));
    }
  }
  EXPECT_NE(std::unique_ptr<char[]>(new char[0]), nullptr);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  volatile std::size_t most = std::numeric_limits<std::size_t>::max() / 2;
  EXPECT_THROW(::operator delete(::operator new(most)), std::bad_alloc);
  EXPECT_THROW(::operator delete(::operator new(most, std::align_val_t(64))), std::bad_alloc);
  EXPECT_EQ(::operator new(most, std::nothrow), nullptr);
  static int asked = 0;
  std::set_new_handler([] {
    if (++asked == 3) std::set_new_handler(nullptr);
  });
  EXPECT_THROW(::operator delete(::operator new(most)), std::bad_alloc);
  EXPECT_EQ(asked, 3);
#endif
}

}  // namespace
}  // namespace dynmesh
