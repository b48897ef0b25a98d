// How well a scene's clouds hide its objects from its sensor: the same lines of sight with the clouds and without.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "octree/base/progress.h"
#include "scene/file/description.h"
#include "sensor/picture/image.h"
#include "sensor/sight/obscuration.h"

namespace obscura {

struct ObscurationWish {
  /// Names; none: every object that is wholly in the picture.
  std::vector<std::string> objects;
  ObscurationSettings thresholds;  ///< without a difference_K the detector's noise, where the scene has it in kelvin
  int replicas = 8;                ///< repetitions with random numbers of their own, 2 or more: they give the intervals
  int ring_px = 0;                 ///< width of the surroundings, pixels; 0: see mask_of()
  bool pictures = false;
  std::optional<double> time_s;  ///< in place of the scene's
};

struct ObjectObscuration {
  std::string name;
  ObjectMask mask;
  int lines_per_pixel = 0;  ///< of sight, over all replicas
  std::vector<BandObscuration> bands;
  std::vector<std::string> notes;
};

struct Obscuration {
  std::string scene, hash;
  std::uint64_t seed = 1;
  double time_s = 0;
  ObscurationWish wish;
  int replicas = 0;  ///< that were done
  std::vector<ObjectObscuration> objects;
  std::vector<std::string> left_out;   ///< objects that nobody asked for, and why they are not there
  std::optional<Image> with, without;  ///< the pictures, with the scene's settings
  std::vector<std::string> warnings;
  std::optional<std::string> failure;  ///< why the numbers cannot be trusted, where they cannot
  bool partial = false;                ///< cancelled: fewer replicas, or no pictures
};

/// @throws InputError where the scene has no cloud, an object is unknown, not in view, too small or without
/// surroundings; else as build_world() and Session::render(); NumericalError where it was cancelled with less
/// than two replicas
Obscuration find_obscuration(const Description& scene, const ObscurationWish& wish, const Progress& progress = {});

/// For people; for programs, numbers in full precision; for spreadsheets, one number a line.
std::string obscuration_table(const Obscuration& obscuration);
std::string obscuration_json(const Obscuration& obscuration);
std::string obscuration_csv(const Obscuration& obscuration);
/// A page with pictures and tables; needs no other file. Written under a temporary name and renamed.
/// @throws ResourceError
void write_obscuration_html(const std::filesystem::path& file, const Obscuration& obscuration);

}  // namespace obscura
