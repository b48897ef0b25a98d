// Files of the shared data folder, which may be absent: then a test says so and returns.
#pragma once

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/support/places.h"

namespace obscura::test {

/// The path of a file below ../shared, or an empty path with a loud warning.
inline std::filesystem::path shared_file(const std::string& name) {
  const std::filesystem::path path = shared_path(name);
  if (std::filesystem::exists(path)) return path;
  WARN("SKIPPED: " << path.string() << " is absent");
  return {};
}

}  // namespace obscura::test
