// Files are written beside their place and renamed: what was there is whole until what comes is whole.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>

namespace obscura {

/// Calls `write` with a temporary name of the same extension in the same folder, then renames. Nothing is left
/// behind where it throws.
/// @throws ResourceError where it cannot be renamed, and what `write` throws
void write_whole(const std::filesystem::path& path, const std::function<void(const std::filesystem::path&)>& write);

/// The same for a stream of bytes, closed and checked. @throws ResourceError where it cannot be written
void write_whole_stream(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

}  // namespace obscura
