// What the commands share at the terminal: progress, Ctrl-C, outputs that must not be lost, exit codes.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "octree/base/error.h"
#include "octree/base/progress.h"
#include "scene/page/progress_bar.h"

namespace obscura::cli {

/// Exit codes of the program.
enum Exit : int { kDone = 0, kBadInput = 2, kResource = 3, kNumerical = 4 };

/// A flag that the first Ctrl-C (or SIGTERM) sets; the second ends the program at once.
const std::atomic<bool>& cancel_flag();
void catch_interrupts();

/// Progress on stderr while it lives.
class Console {
 public:
  explicit Console(bool quiet);
  const Progress& progress() const { return progress_; }
  /// Ends the bar, so that what follows starts on its own line.
  void finish();

 private:
  std::unique_ptr<ProgressBar> bar_;
  Progress progress_;
};

/// Warnings go to stderr, always.
void print_warnings(const std::vector<std::string>& warnings);

/// One line for each problem, on stderr.
void print_problems(const std::vector<Problem>& problems);

/// A file that a command is going to write.
struct Output {
  std::filesystem::path file;
  std::string option;     ///< for messages
  std::string extension;  ///< that it has to have; empty: any
};

/// Refuses outputs before any work is done: they exist and `force` is not given, their folder does not, their
/// extension is another, two are the same, or one would replace an input (even with `force`).
/// @param more  problems of the command beside, told in the same run
/// @throws InputError with all of them; ResourceError where a folder cannot be written to
void check_outputs(const std::vector<Output>& outputs, bool force, const std::vector<std::filesystem::path>& inputs,
                   std::vector<Problem> more = {});

}  // namespace obscura::cli
