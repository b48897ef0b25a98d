// Text files that are whole or not there.
#pragma once

#include <filesystem>
#include <string>

namespace obscura::detail {

/// Written under a temporary name and renamed. @param what it is, for messages: "report"
/// @throws ResourceError where it cannot be written
void write_text(const std::filesystem::path& file, const std::string& text, const std::string& what);

}  // namespace obscura::detail
