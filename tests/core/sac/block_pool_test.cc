// BlockPool against vectors that remember what each block should hold.
#include "core/sac/block_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tests/core/sac/random_script.h"

namespace dynmesh::sac {
namespace {

using testing::NewSeed;
using testing::Random;

TEST(BlockPool, ABlockIsAtLeastAsLargeAsAskedForAndNotMuchLarger) {
  BlockPool pool;
  for (std::uint32_t size = 0; size < 3000; ++size) {
    BlockPool::Block b;
    pool.Resize(b, size);
    EXPECT_GE(b.capacity(), size);
    EXPECT_LE(b.capacity(), size <= 64 ? size + 3 : 2 * size);
    pool.Free(b);
    EXPECT_EQ(b.capacity(), 0u);
  }
}

// The test does not have the memory for blocks at such offsets; only their distinctness is tested.
TEST(BlockPool, BlocksBeyond2To32WordsAreWhereTheyWerePut) {
  for (const std::uint64_t offset :
       {std::uint64_t{2}, std::uint64_t{0xffff'fffe}, std::uint64_t{1} << 32,
        (std::uint64_t{1} << 32) + 2, std::uint64_t{0x123'4567'89ab'cdee},
        (std::uint64_t{1} << 58) - 2}) {
    for (int size_class = 0; size_class < 64; ++size_class) {
      const BlockPool::Block b(offset, size_class);
      ASSERT_EQ(b.offset(), offset);
      ASSERT_EQ(b.size_class(), size_class);
      ASSERT_EQ(b.capacity(), size_class <= 32 ? static_cast<std::uint64_t>(2 * size_class)
                                               : std::uint64_t{128} << (size_class - 33));
    }
  }
  EXPECT_EQ(sizeof(BlockPool::Block), 8u);
  EXPECT_EQ(alignof(BlockPool::Block), 4u);
}

TEST(BlockPool, ShrinkingExchangesAMuchTooLargeBlock) {
  BlockPool pool;
  BlockPool::Block b;
  pool.Resize(b, 1000);
  for (std::uint32_t i = 0; i < 1000; ++i) pool.data(b)[i] = i * i;
  pool.Resize(b, 10);
  EXPECT_LE(b.capacity(), 24u);
  for (std::uint32_t i = 0; i < 10; ++i) EXPECT_EQ(pool.data(b)[i], i * i);
  pool.Resize(b, 0);
  EXPECT_EQ(b.capacity(), 0u);
}

TEST(BlockPool, ASlightlySmallerSizeKeepsTheBlock) {
  BlockPool pool;
  BlockPool::Block b;
  pool.Resize(b, 40);
  const std::uint32_t offset = b.offset();
  for (std::uint32_t size = 40; size > 20; --size) pool.Resize(b, size);
  EXPECT_EQ(b.offset(), offset);
}

// Blocks of all sizes grow, shrink and go; each keeps its words.
TEST(BlockPool, BlocksKeepTheirWordsAndNeverOverlap) {
  Random random(NewSeed());
  struct Told {
    BlockPool::Block block;
    std::vector<std::uint32_t> words;
  };
  std::vector<Told> all(300);
  BlockPool pool;
  const auto verify = [&](const Told& t) {
    ASSERT_GE(t.block.capacity(), t.words.size());
    ASSERT_TRUE(std::equal(t.words.begin(), t.words.end(), pool.data(t.block)));
  };
  for (int step = 0; step < 100'000; ++step) {
    Told& t = all[random.Below(all.size())];
    if (random.OneIn(8)) {
      pool.Free(t.block);
      t.words.clear();
    } else {
      const std::size_t size = random.OneIn(20) ? random.Below(2000) : random.Below(80);
      pool.Resize(t.block, static_cast<std::uint32_t>(size));
      const std::size_t kept = std::min(size, t.words.size());
      ASSERT_TRUE(std::equal(t.words.begin(), t.words.begin() + static_cast<long>(kept),
                             pool.data(t.block)));
      // To the brim, so that an overlap does not go unseen.
      t.words.resize(t.block.capacity());
      for (std::uint32_t& w : t.words) w = static_cast<std::uint32_t>(random.Word());
      std::copy(t.words.begin(), t.words.end(), pool.data(t.block));
    }
    if (step % 1000 == 0) std::for_each(all.begin(), all.end(), verify);
  }
  std::for_each(all.begin(), all.end(), verify);
}

TEST(BlockPool, FreedBlocksAreUsedAgain) {
  BlockPool pool;
  std::vector<BlockPool::Block> blocks(1000);
  std::size_t bytes = 0;
  for (int round = 0; round < 10; ++round) {
    for (std::uint32_t i = 0; i < blocks.size(); ++i) pool.Resize(blocks[i], i % 90 + 1);
    for (BlockPool::Block& b : blocks) pool.Free(b);
    if (round == 0) bytes = pool.bytes();
  }
  EXPECT_EQ(pool.bytes(), bytes);
}

}  // namespace
}  // namespace dynmesh::sac
