#include "scene/text_file_io.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include <unistd.h>

#include "octree/base/error.h"

namespace obscura::detail {

void write_text(const std::filesystem::path& file, const std::string& text, const std::string& what) {
  std::filesystem::path temporary = file;
  temporary += ".part" + std::to_string(getpid());
  const auto fail = [&](const std::string& why) {
    std::remove(temporary.c_str());
    throw ResourceError(file.string(), "the " + what + " cannot be written: " + why, "check that the folder exists and that the disk has space");
  };
  errno = 0;
  {
    std::ofstream stream(temporary, std::ios::binary);
    stream << text;
    stream.close();
    if (!stream) fail(errno ? std::strerror(errno) : "unknown reason");
  }
  std::error_code error;
  std::filesystem::rename(temporary, file, error);
  if (error) fail(error.message());
}

}  // namespace obscura::detail
