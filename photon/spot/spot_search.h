// How a spot is searched: what covers it, then everything in front of that, then the same in mirrors.
#pragma once

#include <array>
#include <vector>

#include "photon/spot/spot.h"
#include "photon/spot/spot_region.h"
#include "photon/spot/spot_seen.h"
#include "photon/world/face_index.h"
#include "photon/world/world.h"

namespace obscura {

class SpotQuery::Search {
 public:
  Search(const World& world, const SpotThresholds& thresholds, int specular_depth);

  Criterion operator()(const Spot& spot);

 private:
  /// A search that has looked at more faces than this gives up: the spot is refined.
  static constexpr int kMostFaces = 4096;

  using Fragment = detail::Fragment;
  using Region = detail::SpotRegion;
  using SeenFace = detail::SeenFace;

  /// A spot to be searched, with what its rays start from.
  struct Looking {
    Spot spot;
    Ray middle;  // one of them
    bool has_middle = true;
    FaceId from;                      // what they start on
    std::optional<HalfSpace> mirror;  // where they start
    bool flat = false;                // the mirror is a plane: faces in it are not seen
  };
  struct Level {
    detail::Seen seen;
    std::vector<Looking> mirrors;
  };
  /// A face that covers a part of the spot: nothing has been found in front of that part so far.
  struct Cover {
    std::uint32_t face;
    HalfSpace plane;  // inside: in front
    std::array<Vec3d, 3> corners;
    double tie;  // m: nearer to the plane than this, the lower name is met
  };
  /// The faces that the present search has visited; clearing takes no time.
  class Visited {
   public:
    void clear() noexcept;
    /// False where it was there.
    bool insert(std::uint32_t face) noexcept;
    bool contains(std::uint32_t face) const noexcept;

   private:
    static constexpr std::size_t kSlots = 1 << 14;
    static std::size_t slot(std::uint32_t face) noexcept { return (face * std::uint64_t{0x9e3779b97f4a7c15u}) >> 50; }
    std::vector<std::uint64_t> slots_ = std::vector<std::uint64_t>(kSlots, 0);  // search << 32 | face
    std::uint64_t search_ = 0;
  };

  Criterion look(const Looking& looking, std::size_t level);
  Criterion reflect(std::size_t level);
  /// Visits the faces that are connected with one, from edge to edge.
  Criterion flood(const Region& region, const Looking& looking, FaceId start, Level& level);
  Criterion search_all(const Region& region, const Looking& looking, Level& level);

  bool permeable(std::uint32_t object, std::uint32_t face) const noexcept;
  std::size_t slot_of(std::uint32_t object, std::uint32_t face) const noexcept;
  /// Adds a face of a mesh whose part in the region is given.
  Criterion see(const Region& region, const Looking& looking, FaceId id, const std::array<Vec3d, 3>& corners,
                const Vec3d& normal, const Fragment& part, Level& level);
  /// Adds a ball if it is in the region. Sets limit_ where it covers all of it.
  Criterion see(const Region& region, const Ball& ball, Level& level);
  Criterion add_discs(const Region& region, Level& level);
  bool hidden(const Region& region, FaceId id, const Fragment& part) const noexcept;
  bool continues(const HalfSpace& edge, double from_side, std::uint32_t object, std::uint32_t side,
                 double noise) const noexcept;
  HalfSpace through_edge(const Region& region, const Vec3d& a, const Vec3d& b) const noexcept;
  bool mirrors(int material) const noexcept { return material >= 0 && mirror_[static_cast<std::size_t>(material)]; }
  Criterion add_mirror(Level& level, const Looking& mirrored);
  Criterion gave_up() const noexcept;

  const World& world_;
  SpotThresholds asked_;
  const FaceIndex* index_ = nullptr;  // none: no surfaces
  double slack_ = 0;
  double unsure_ = 0;         // m by which positions may be rounded
  std::vector<char> mirror_;  // per material
  bool by_angle_ = false;     // a material's emissivity depends on it
  std::size_t depth_ = 0;     // of mirrors
  std::vector<Level> levels_;

  Visited visited_;
  std::uint32_t visited_surface_ = FaceId::kNone;
  std::vector<std::uint32_t> queue_;
  std::vector<Cover> cover_;
  std::uint32_t cover_surface_ = FaceId::kNone;
  bool cover_known_ = false;  // cover_ holds all of it
  bool covered_ = false;
  std::optional<HalfSpace> front_;  // what is outside of it is hidden
  double limit_ = kInfinity;        // m along the axis: what is farther is hidden
  int faces_ = 0;                   // looked at
};

}  // namespace obscura
