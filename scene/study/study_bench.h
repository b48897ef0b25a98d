// Where a study's pictures are made and timed.
#pragma once

#include <list>
#include <memory>
#include <optional>

#include "scene/session/session.h"
#include "scene/study/study.h"

namespace obscura {

/// One picture and what it cost.
struct StudyPicture {
  Picture picture;
  std::optional<Picture> errors;  ///< of methods on a grid: the error that they state
  StudySeconds seconds;
  StudyBytes bytes;
  double peak_MiB = 0;
};

/// What a study asks of: a scene that makes pictures.
class StudyBench {
 public:
  virtual ~StudyBench() = default;
  /// Name, bands and sizes.
  virtual Study describe() const = 0;
  virtual const StudyTraits& traits() const = 0;
  /// A cancelled picture may be anything.
  /// @throws NumericalError, InputError, ResourceError where the method refuses
  virtual StudyPicture measure(const StudySetting& setting, std::uint64_t seed, const Progress& progress) = 0;
};

/// The real one: Sessions of a scene whose picture was made smaller. The last few Worlds are kept while their octrees
/// are small; a photon map is kept until another is asked for.
class SessionBench final : public StudyBench {
 public:
  /// Builds the scene's own World. @throws as build_world()
  SessionBench(Description scene, int pixels, StudyClock clock, const Progress& progress);

  Study describe() const override;
  const StudyTraits& traits() const override { return traits_; }
  StudyPicture measure(const StudySetting& setting, std::uint64_t seed, const Progress& progress) override;

 private:
  struct Built {
    StudySetting of;
    std::unique_ptr<Session> session;
    StudySeconds::Stage world;
    std::optional<SolutionBasis> solved;  // what the session holds
    StudySeconds::Stage map;              // spent on it
    double octree_bytes = 0;
  };

  Built& built_for(const StudySetting& setting, const Progress& progress);
  StudySeconds::Stage now() const { return {clock_.cpu_s(), clock_.wall_s()}; }
  StudyPicture picture_of(const Built& built, const Rendered& rendered) const;

  Description scene_;
  std::array<int, 2> full_resolution_;
  StudyClock clock_;
  StudyTraits traits_;
  std::vector<std::string> warnings_;  // of the scene and its own plan
  std::list<Built> built_;             // the last used first
};

}  // namespace obscura
