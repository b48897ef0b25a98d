// Second half of a build: what lies above the bricks. Equal leaves are merged upward, the bounds of
// inner cells gathered, the blocks listed.
#include <tbb/parallel_for.h>

#include <array>

#include "octree/build/collect.h"

namespace obscura::detail {
namespace {

Vec3i half(const Vec3i& size) noexcept { return {(size.x + 1) / 2, (size.y + 1) / 2, (size.z + 1) / 2}; }

std::size_t volume(const Vec3i& size) noexcept {
  return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
}

// Calls f(index of the parent, its children's indices, their number) for all cells of the level above one of
// the given size; children outside the table are left out.
template <class F>
void for_each_parent(const Vec3i& size, F&& f) {
  const Vec3i parents = half(size);
  tbb::parallel_for(0, parents.z, [&](int z) {
    std::size_t parent =
        static_cast<std::size_t>(z) * static_cast<std::size_t>(parents.x) * static_cast<std::size_t>(parents.y);
    for (int y = 0; y < parents.y; ++y) {
      for (int x = 0; x < parents.x; ++x, ++parent) {
        std::size_t children[8];
        int count = 0;
        for (int k = 0; k < 8; ++k) {
          const int cx = 2 * x + (k & 1), cy = 2 * y + ((k >> 1) & 1), cz = 2 * z + (k >> 2);
          if (cx >= size.x || cy >= size.y || cz >= size.z) continue;
          children[count++] =
              (static_cast<std::size_t>(cz) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(cy)) *
                  static_cast<std::size_t>(size.x) +
              static_cast<std::size_t>(cx);
        }
        f(parent, children, count);
      }
    }
  });
}

int top_level_of(const Vec3i& size) noexcept {
  int level = 3;
  while ((std::max(std::max(size.x, size.y), size.z) - 1) >> (level - 3)) ++level;
  return level;
}

}  // namespace

void merge_leaves(TreeData& tree, const std::function<bool(std::uint32_t word)>& is_uniform,
                  const std::function<std::uint32_t(int level, std::span<const std::uint32_t, 8>)>& merge) {
  // Each level's cells: a word where the whole cell is one leaf.
  const int top = top_level_of(tree.size);
  std::vector<std::vector<std::uint32_t>> levels(static_cast<std::size_t>(top) + 1);
  std::vector<Vec3i> sizes(levels.size(), tree.size);
  const std::vector<std::uint32_t>* below = &tree.table;
  for (std::size_t level = 4; level < levels.size(); ++level) {
    const Vec3i size = sizes[level - 1];
    sizes[level] = half(size);
    levels[level].resize(volume(sizes[level]));
    for_each_parent(size, [&](std::size_t parent, const std::size_t* children, int count) {
      bool all_empty = true, all_leaves = true;
      std::array<std::uint32_t, 8> words;
      for (int k = 0; k < count && all_leaves; ++k) {
        const std::uint32_t word = (*below)[children[k]];
        words[static_cast<std::size_t>(k)] = word;
        if (Word::is_empty(word)) continue;
        all_empty = false;
        all_leaves = word != kNotMerged && (level > 4 || is_uniform(word));
      }
      std::uint32_t merged = kNotMerged;
      if (all_leaves) {
        if (all_empty) {
          merged = Word::empty(static_cast<int>(level));
        } else if (count == 8) {
          merged = merge(static_cast<int>(level), words);
        }
      }
      levels[level][parent] = merged;
    });
    below = &levels[level];
  }

  // Every word of the table becomes that of the largest leaf that holds its place.
  const std::size_t nx = static_cast<std::size_t>(tree.size.x), ny = static_cast<std::size_t>(tree.size.y);
  tbb::parallel_for(0, tree.size.z, [&](int z) {
    std::size_t at = static_cast<std::size_t>(z) * nx * ny;
    for (int y = 0; y < tree.size.y; ++y) {
      for (int x = 0; x < tree.size.x; ++x, ++at) {
        for (std::size_t level = 4; level < levels.size(); ++level) {
          const int shift = static_cast<int>(level) - 3;
          const std::size_t cell = (static_cast<std::size_t>(z >> shift) * static_cast<std::size_t>(sizes[level].y) +
                                    static_cast<std::size_t>(y >> shift)) *
                                       static_cast<std::size_t>(sizes[level].x) +
                                   static_cast<std::size_t>(x >> shift);
          if (levels[level][cell] == kNotMerged) break;
          tree.table[at] = levels[level][cell];
        }
      }
    }
  });
}

void merge_equal(TreeData& tree, RecordStore& store, UniformRecords& uniform) {
  const std::size_t channels = tree.channels.size();
  std::mutex mutex;
  const auto headers = [&](std::uint32_t word) { return reinterpret_cast<const ChannelHeader*>(store.at(word)); };
  merge_leaves(
      tree,
      [&](std::uint32_t word) {
        const std::lock_guard lock(mutex);
        return headers(word)[0].cell_level() >= 3;
      },
      [&](int level, std::span<const std::uint32_t, 8> children) {
        // Equal uniform leaves have the same record.
        for (const std::uint32_t child : children) {
          if (child != children[0]) return kNotMerged;
        }
        const std::lock_guard lock(mutex);
        std::vector<float> values(channels);
        for (std::size_t c = 0; c < channels; ++c) values[c] = headers(children[0])[c].offset;
        return uniform.word(store, level, values);
      });
}

namespace {

// Chebyshev distance in bricks from each empty word to the nearest that is not, exact by one pass forward and one
// back (Rosenfeld and Pfaltz 1966). What is outside the table is empty.
void mark_distances(TreeData& tree) {
  const int nx = tree.size.x, ny = tree.size.y, nz = tree.size.z;
  std::vector<std::uint8_t> distance(tree.table.size());
  for (std::size_t i = 0; i < distance.size(); ++i)
    distance[i] = Word::is_empty(tree.table[i]) ? Word::kMaxDistance : 0;
  const auto index = [&](int x, int y, int z) {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(ny) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(nx) +
           static_cast<std::size_t>(x);
  };
  const auto relax = [&](int x, int y, int z, int side) {
    std::uint8_t& here = distance[index(x, y, z)];
    if (here == 0) return;
    int nearest = here;
    for (int k = 0; k < 13; ++k) {
      // The 13 neighbours that come before (side -1) or after (side 1) in the order of the table.
      const int dx = side * (1 - k % 3), dy = side * (1 - k / 3 % 3), dz = side * (1 - k / 9);
      const int i = x + dx, j = y + dy, l = z + dz;
      if (i < 0 || j < 0 || l < 0 || i >= nx || j >= ny || l >= nz) continue;
      nearest = std::min(nearest, distance[index(i, j, l)] + 1);
    }
    here = static_cast<std::uint8_t>(nearest);
  };
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) relax(x, y, z, -1);
    }
  }
  for (int z = nz - 1; z >= 0; --z) {
    for (int y = ny - 1; y >= 0; --y) {
      for (int x = nx - 1; x >= 0; --x) relax(x, y, z, 1);
    }
  }
  for (std::size_t i = 0; i < distance.size(); ++i) {
    if (distance[i] != 0) tree.table[i] = Word::with_distance(tree.table[i], distance[i]);
  }
}

}  // namespace

void finish(TreeData& tree) {
  tree.top_level = top_level_of(tree.size);
  mark_distances(tree);
  const std::size_t channels = tree.channels.size();

  // A block stands at its first word.
  tree.blocks.clear();
  std::size_t at = 0;
  for (int z = 0; z < tree.size.z; ++z) {
    for (int y = 0; y < tree.size.y; ++y) {
      for (int x = 0; x < tree.size.x; ++x, ++at) {
        const std::uint32_t word = tree.table[at];
        if (Word::is_empty(word)) continue;
        const int level = tree.block_level(word);
        if (((x | y | z) & ((1 << (level - 3)) - 1)) == 0) tree.blocks.push_back(static_cast<std::uint32_t>(at));
      }
    }
  }
  tree.blocks.shrink_to_fit();

  // Bounds of each cell from those of its children.
  tree.pyramid.clear();
  tree.pyramid.resize(static_cast<std::size_t>(tree.top_level - 3));
  Vec3i size = tree.size;
  for (int level = 4; level <= tree.top_level; ++level) {
    PyramidLevel& cells = tree.pyramid[static_cast<std::size_t>(level - 4)];
    const PyramidLevel* below = level > 4 ? &tree.pyramid[static_cast<std::size_t>(level - 5)] : nullptr;
    cells.size = half(size);
    cells.cells.resize(volume(cells.size) * channels);
    const Vec3i children_size = size;
    for_each_parent(size, [&](std::size_t parent, const std::size_t* children, int count) {
      for (std::size_t c = 0; c < channels; ++c) {
        Bounds bounds{kFloatMax, -kFloatMax, 0};
        double sum = 0, whole = 0;
        for (int k = 0; k < count; ++k) {
          const int i = static_cast<int>(children[k]);
          const Vec3i cell(i % children_size.x, i / children_size.x % children_size.y,
                           i / (children_size.x * children_size.y));
          const Vec3i corner = tree.origin + Vec3i(cell.x << (level - 1), cell.y << (level - 1), cell.z << (level - 1));
          const Bounds child =
              below ? below->cells[children[k] * channels + c] : cell_bounds(tree, static_cast<int>(c), {corner, 3});
          const double part = domain_volume(tree.domain, {corner, level - 1});
          bounds.min = std::min(bounds.min, child.min);
          bounds.max = std::max(bounds.max, child.max);
          sum += part * static_cast<double>(child.mean);
          whole += part;
        }
        bounds.mean = whole > 0 ? static_cast<float>(sum / whole) : 0.0f;
        cells.cells[parent * channels + c] = bounds;
      }
    });
    size = cells.size;
  }
}

}  // namespace obscura::detail
