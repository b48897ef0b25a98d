// Where the time of a run goes.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "scene/goal/accuracy.h"

namespace obscura {

class Stages {
 public:
  /// Seconds since the last stage ended.
  void end(const char* stage) {
    const double now = since_begin();
    seconds_.emplace_back(stage, now - last_);
    last_ = now;
  }
  /// The stages of an image in passes, each of which is many stretches of time.
  void end(const Accuracy& accuracy) {
    for (const auto& [stage, seconds] :
         {std::pair("pilot", accuracy.pilot_s), {"photons", accuracy.photons_s}, {"image", accuracy.image_s}}) {
      seconds_.emplace_back(stage, seconds);
    }
    last_ = since_begin();
  }
  double since_begin() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  std::vector<std::pair<std::string, double>> take() { return std::move(seconds_); }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double last_ = 0;
  std::vector<std::pair<std::string, double>> seconds_;
};

}  // namespace obscura
