#include "tests/support/places.h"

namespace obscura::test {

std::string source_file(const std::string& name) { return std::string(OBSCURA_SOURCE_DIR "/") + name; }
std::string shared_path(const std::string& name) { return std::string(OBSCURA_SOURCE_DIR "/../shared/") + name; }
std::string data_file(const std::string& name) { return std::string(OBSCURA_SOURCE_DIR "/tests/data/") + name; }
std::string program_file() { return OBSCURA_PROGRAM; }

}  // namespace obscura::test
