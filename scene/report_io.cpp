// The report's file.
#include "scene/report.h"
#include "scene/text_file_io.h"

#include <sys/resource.h>

namespace obscura {

void write_report(const std::filesystem::path& file, const Report& report) {
  detail::write_text(file, to_json(report), "report");
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
