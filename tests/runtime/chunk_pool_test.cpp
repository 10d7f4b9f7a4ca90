// SPDX-License-Identifier: Apache-2.0
#include "hypgen/memory/chunk_pool.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <thread>
#include <vector>

namespace hypgen {
namespace {

struct alignas(64) Line {
  unsigned char bytes[64];
};

std::uintptr_t address(const void* pointer) { return reinterpret_cast<std::uintptr_t>(pointer); }

TEST(ChunkPool, GivesBlocksOfAnyKindInOrder) {
  ChunkPool pool(1 << 20, 1);
  PoolCursor cursor(pool);
  const Ref<std::uint32_t> word = cursor.take<std::uint32_t>();
  const Ref<Line> line = cursor.take<Line>();
  const Ref<double> row = cursor.take<double>(100 * sizeof(double));
  ASSERT_TRUE(word && line && row);
  EXPECT_FALSE(Ref<Line>{});
  EXPECT_EQ(address(&pool[line]) % 64, 0U);
  EXPECT_EQ(address(&pool[word]) % ChunkPool::kUnit, 0U);
  EXPECT_GE(address(&pool[line]), address(&pool[word] + 1));
  EXPECT_EQ(address(&pool[row]), address(&pool[line] + 1));
  EXPECT_EQ(pool.taken(), pool.chunk_bytes());
}

TEST(ChunkPool, TakesChunksByItsSizeAndItsThreads) {
  EXPECT_EQ(ChunkPool(std::size_t{1} << 30, 1).chunk_bytes(), std::size_t{2} << 20);
  EXPECT_EQ(ChunkPool(std::size_t{1} << 20, 1).chunk_bytes(), std::size_t{128} << 10);
  EXPECT_EQ(ChunkPool(std::size_t{1} << 20, 16).chunk_bytes(), std::size_t{8} << 10);
  EXPECT_EQ(ChunkPool(100, 16).chunk_bytes(), std::size_t{4} << 10);
}

TEST(ChunkPool, LetsALargeBlockBeAndGoesOnWithTheChunk) {
  ChunkPool pool(1 << 20, 16);
  PoolCursor cursor(pool);
  const auto before = cursor.take<Line>();
  const auto large = cursor.take<Line>(2 * pool.chunk_bytes());
  const auto after = cursor.take<Line>();
  ASSERT_TRUE(before && large && after);
  EXPECT_EQ(&pool[after], &pool[before] + 1);
  EXPECT_EQ(pool.taken(), 3 * pool.chunk_bytes());
}

TEST(ChunkPool, TakesTheLastBlockBack) {
  ChunkPool pool(1 << 20, 16);
  PoolCursor cursor(pool);
  cursor.take<std::uint32_t>();
  for (const std::size_t bytes : {sizeof(Line), pool.chunk_bytes() - 64, 2 * pool.chunk_bytes()}) {
    const auto lost = cursor.take<Line>(bytes);
    const std::size_t taken = pool.taken();
    cursor.take_back(lost);
    const auto again = cursor.take<Line>(bytes);
    EXPECT_EQ(lost, again) << bytes;
    EXPECT_EQ(pool.taken(), taken) << bytes;
  }
}

// All of it can be used, whatever the size of a chunk; then no block is given until it is reset.
TEST(ChunkPool, IsFullAtItsEndAndEmptyAfterReset) {
  ChunkPool pool(10000, 1);
  PoolCursor cursor(pool);
  Ref<Line> first = cursor.take<Line>();
  std::size_t lines = 1;
  while (cursor.take<Line>()) ++lines;
  EXPECT_EQ(lines, 10000 / sizeof(Line));
  EXPECT_EQ(pool.taken(), pool.capacity());
  EXPECT_FALSE(cursor.take<std::uint32_t>());
  pool.reset();
  cursor.reset();
  EXPECT_EQ(pool.taken(), 0U);
  EXPECT_EQ(cursor.take<Line>(), first);
}

// Takes blocks of random sizes until the pool is full, some of them twice, and marks them as its own.
void fill(ChunkPool& pool, unsigned char mark, std::vector<std::pair<std::size_t, unsigned char*>>& blocks) {
  PoolCursor cursor(pool);
  std::mt19937 random(mark);
  while (true) {
    const std::size_t bytes = random() % 8 == 0 ? random() % 20000 + 1 : random() % 200 + 1;
    Ref<unsigned char> block = cursor.take<unsigned char>(bytes);
    if (!block) return;
    if (random() % 4 == 0) {
      std::memset(&pool[block], 0, bytes);
      cursor.take_back(block);
      block = cursor.take<unsigned char>(bytes);
    }
    std::memset(&pool[block], mark, bytes);
    blocks.emplace_back(bytes, &pool[block]);
  }
}

TEST(ChunkPool, GivesNoByteToTwoThreads) {
  constexpr std::size_t kThreads = 4;
  ChunkPool pool(8 << 20, kThreads);
  for (int round = 0; round < 3; ++round) {
    std::vector<std::vector<std::pair<std::size_t, unsigned char*>>> blocks(kThreads);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < kThreads; ++t) {
      threads.emplace_back(fill, std::ref(pool), static_cast<unsigned char>(t + 1), std::ref(blocks[t]));
    }
    for (std::thread& thread : threads) thread.join();
    std::size_t bytes = 0;
    for (std::size_t t = 0; t < kThreads; ++t) {
      for (const auto& [size, block] : blocks[t]) {
        bytes += size;
        for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(block[i], t + 1);
      }
    }
    EXPECT_GT(bytes, pool.capacity() / 2);
    pool.reset();
  }
}

}  // namespace
}  // namespace hypgen
