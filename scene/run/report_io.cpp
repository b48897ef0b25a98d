// The report's file.
#include <sys/resource.h>

#include <ostream>

#include "scene/run/report.h"
#include "sensor/picture/whole_file_io.h"

namespace obscura {

void write_report(const std::filesystem::path& file, const Report& report) {
  write_whole_stream(file, [&](std::ostream& stream) { stream << to_json(report); });
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
