// Shows progress to people: a bar with the time left on a terminal, a plain line now and then elsewhere.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace obscura {

/// Takes Progress reports from any thread; never slows the work down by more than a try-lock.
class ProgressBar {
 public:
  using Clock = std::function<double()>;                ///< seconds, from any origin
  using Write = std::function<void(std::string_view)>;  ///< where the text goes (stderr)

  /// @param terminal draws in place; otherwise whole lines: at most one in 10 s, and one for each
  /// stage that took a second or more
  ProgressBar(bool terminal, Clock clock, Write write);
  ~ProgressBar() { finish(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void report(std::string_view stage, std::uint64_t done, std::uint64_t total);

  /// Ends the last stage's line.
  void finish();

 private:
  void end_stage(double now);
  std::string line(double now) const;

  bool terminal_;
  Clock clock_;
  Write write_;
  std::mutex mutex_;
  std::string stage_;
  std::uint64_t done_ = 0;
  std::uint64_t total_ = 0;
  double begin_ = 0;
  double drawn_ = 0;
};

/// "0.4 s", "42 s", "3 min 20 s", "2 h 5 min".
std::string duration_text(double seconds);

}  // namespace obscura
