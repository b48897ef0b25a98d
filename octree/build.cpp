#include "octree/build.h"

#include <chrono>

#include "octree/base/error.h"
#include "octree/collect.h"

namespace obscura {

std::pair<Octree, BuildReport> build_octree(const VoxelStream& stream, const BuildSettings& settings,
                                            const Progress& progress) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  const Clock::time_point start = Clock::now();
  BuildReport report;
  detail::TreeData tree = detail::collect(stream, progress);
  report.pour_seconds = seconds_since(start);
  static_cast<void>(settings);
  report.seconds = seconds_since(start);
  return {Octree(std::move(tree)), report};
}

}  // namespace obscura
