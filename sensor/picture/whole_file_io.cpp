#include "sensor/picture/whole_file_io.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include "octree/base/error.h"

namespace obscura {

namespace fs = std::filesystem;

void write_whole(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  static std::atomic<unsigned> counter{0};
  fs::path temporary = path;
  temporary.replace_filename(
      fmt::format(".{}.{}-{}{}", path.stem().string(), ::getpid(), counter++, path.extension().string()));
  std::error_code ignored, failure;
  try {
    write(temporary);
    fs::rename(temporary, path, failure);
  } catch (...) {
    fs::remove(temporary, ignored);
    throw;
  }
  if (failure) {
    fs::remove(temporary, ignored);
    throw ResourceError(path.string(), "cannot be written: " + failure.message(),
                        "check the folder and its permissions");
  }
}

void write_whole_stream(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  write_whole(path, [&](const fs::path& temporary) {
    errno = 0;
    std::ofstream stream(temporary, std::ios::binary);
    if (stream) write(stream);
    stream.close();
    if (!stream) {
      throw ResourceError(path.string(),
                          std::string("cannot be written: ") + (errno ? std::strerror(errno) : "unknown reason"),
                          "check the folder, its permissions and the space left");
    }
  });
}

}  // namespace obscura
