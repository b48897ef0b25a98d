// Numbers as people type them on a command line, and as they like to read them.
#pragma once

#include <cstdint>
#include <string>

namespace obscura::cli {

/// Seconds: 90, 30s, 5min, 1.5h, 250ms, 2d. @throws InputError naming the option
double parse_seconds(const std::string& text, const std::string& option);

/// A fraction: 0.03 or 3%. At least 0. @throws InputError naming the option
double parse_fraction(const std::string& text, const std::string& option);

/// The error of a ray's transmission that is allowed: a fraction below 1. @throws InputError naming the option
double parse_tolerance(const std::string& text, const std::string& option);

/// "1.4 MiB"
std::string bytes_text(std::uint64_t bytes);

}  // namespace obscura::cli
