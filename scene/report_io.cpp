// The report's file.
#include "octree/base/error.h"
#include "scene/report.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include <sys/resource.h>
#include <unistd.h>

namespace obscura {

void write_report(const std::filesystem::path& file, const Report& report) {
  std::filesystem::path temporary = file;
  temporary += ".part" + std::to_string(getpid());
  errno = 0;
  {
    std::ofstream stream(temporary, std::ios::binary);
    stream << to_json(report);
    stream.close();
    if (!stream) {
      const std::string why = errno ? std::strerror(errno) : "unknown reason";
      std::remove(temporary.c_str());
      throw ResourceError(file.string(), "the report cannot be written: " + why,
                          "check that the folder exists and that the disk has space");
    }
  }
  std::error_code error;
  std::filesystem::rename(temporary, file, error);
  if (error) {
    std::remove(temporary.c_str());
    throw ResourceError(file.string(), "the report cannot be written: " + error.message(), "check the folder");
  }
}

double peak_memory_MiB() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
#ifdef __APPLE__
  return static_cast<double>(usage.ru_maxrss) / (1024.0 * 1024.0);
#else
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
#endif
}

}  // namespace obscura
