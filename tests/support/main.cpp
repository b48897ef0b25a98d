// The one translation unit that compiles Catch's main. OBSCURA_TRAP_FPE names the floating point exceptions
// that end a test there and then, on every thread: see tests/README.md.
#define CATCH_CONFIG_RUNNER
#include <tbb/task_scheduler_observer.h>

#include <catch2/catch.hpp>
#include <cfenv>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>

namespace {

/// The exceptions that the environment asks for, or nothing where it names one that there is not.
std::optional<int> trapped_exceptions() {
  const char* wish = std::getenv("OBSCURA_TRAP_FPE");
  int exceptions = 0;
  std::istringstream words(wish ? wish : "");
  for (std::string word; std::getline(words, word, ',');) {
    if (word == "invalid") {
      exceptions |= FE_INVALID;
    } else if (word == "overflow") {
      exceptions |= FE_OVERFLOW;
    } else if (word == "divbyzero") {
      exceptions |= FE_DIVBYZERO;
    } else {
      std::fprintf(stderr, "OBSCURA_TRAP_FPE: \"%s\" is none of invalid, overflow and divbyzero\n", word.c_str());
      return std::nullopt;
    }
  }
  return exceptions;
}

bool trap(int exceptions) {
  std::feclearexcept(FE_ALL_EXCEPT);
#ifdef __GLIBC__
  return exceptions == 0 || feenableexcept(exceptions) != -1;
#else
  return exceptions == 0;
#endif
}

/// Workers take the exceptions over with their first task.
class TrapOnWorkers : public tbb::task_scheduler_observer {
 public:
  explicit TrapOnWorkers(int exceptions) : exceptions_(exceptions) { observe(exceptions != 0); }
  ~TrapOnWorkers() { observe(false); }
  void on_scheduler_entry(bool) override { trap(exceptions_); }

 private:
  int exceptions_;
};

}  // namespace

int main(int argc, char** argv) {
  const std::optional<int> exceptions = trapped_exceptions();
  if (!exceptions || !trap(*exceptions)) return 2;
  const TrapOnWorkers workers(*exceptions);
  return Catch::Session().run(argc, argv);
}
