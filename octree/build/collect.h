// First half of a build: gathers poured voxels into a lossless tree. Records are stored as they
// arrive, so that the voxels are in memory once; only the table knows where they are in space.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "octree/base/progress.h"
#include "octree/source/voxels.h"
#include "octree/tree/layout.h"

namespace obscura::detail {

/// Most words of a top table: 256 MiB; a domain of 3250^3 voxels.
inline constexpr std::uint64_t kMaxTopCells = std::uint64_t{1} << 26;
/// Most bytes of records: what a word can count.
inline constexpr std::uint64_t kMaxRecordBytes = (std::uint64_t{1} << 31) * kRecordUnit;

/// Records in one contiguous piece of memory that grows in place where the system can.
class RecordStore {
 public:
  /// Makes room for a record and returns the word that names it. Pointers from at() may become invalid.
  std::uint32_t add(std::size_t bytes);
  std::byte* at(std::uint32_t word) noexcept { return memory_.get() + kRecordPadding + word * kRecordUnit; }
  /// Makes room for all records at once.
  void reserve(std::size_t bytes);
  /// Gives the memory to the tree, cut to its size.
  void release_to(TreeData& tree);

 private:
  std::unique_ptr<std::byte[], FreeDeleter> memory_;
  std::size_t used_ = 0;
  std::size_t capacity_ = 0;
};

/// An empty tree over the stream's lattice: names, maps, domain, table of empty words.
/// @throws InputError, ResourceError
TreeData make_tree(const VoxelStream& stream);

/// Uniform records, one for each level and set of values.
class UniformRecords {
 public:
  /// The word of the uniform leaf of that level; made in `store` when it is new. Not thread-safe.
  std::uint32_t word(RecordStore& store, int level, std::span<const float> values);
  /// Key of a level and set of values: their bytes.
  static std::string key(int level, std::span<const float> values);

 private:
  std::unordered_map<std::string, std::uint32_t> words_;
};

/// Takes everything that the stream pours.
/// @throws InputError where it pours outside its bounds; ResourceError when cancelled or out of memory.
TreeData collect(const VoxelStream& stream, const Progress& progress);

/// What merge_leaves() is told where a cell's children stay apart.
inline constexpr std::uint32_t kNotMerged = 0x7fffffffu;

/// Merges leaves into their parents, level by level, as far as it goes. Empty leaves merge by themselves; of
/// eight children that are uniform or empty leaves, not all empty, `merge` says what becomes.
/// @param merge (level of the parent, the children's words) -> the parent's word or kNotMerged. Called from
/// several threads; all of a level before any of the next.
void merge_leaves(TreeData& tree, const std::function<bool(std::uint32_t word)>& is_uniform,
                  const std::function<std::uint32_t(int level, std::span<const std::uint32_t, 8>)>& merge);

/// merge_leaves() of what is equal. Records of the parents are added to `store`.
void merge_equal(TreeData& tree, RecordStore& store, UniformRecords& uniform);

/// Fills block list, pyramid of bounds and top level from the finished table and records.
void finish(TreeData& tree);

}  // namespace obscura::detail
