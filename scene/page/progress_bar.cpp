#include "scene/page/progress_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace obscura {
namespace {

constexpr int kBarWidth = 24;
constexpr double kRedraw = 0.1;       // s, on a terminal
constexpr double kPlainEvery = 10.0;  // s, between plain lines
constexpr double kWorthALine = 1.0;   // s

}  // namespace

std::string duration_text(double seconds) {
  if (!(seconds >= 0) || seconds > 1e9) return "?";
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

ProgressBar::ProgressBar(bool terminal, Clock clock, Write write)
    : terminal_(terminal), clock_(std::move(clock)), write_(std::move(write)) {}

void ProgressBar::report(std::string_view stage, std::uint64_t done, std::uint64_t total) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return;
  const double now = clock_();
  if (stage != stage_) {
    end_stage(now);
    stage_ = stage;
    begin_ = now;
    drawn_ = terminal_ ? now - 1 : now;  // a bar shows at once
    done_ = 0;
  }
  done_ = std::max(done_, done);  // threads may report out of order
  total_ = total;
  if (now - drawn_ < (terminal_ ? kRedraw : kPlainEvery)) return;
  drawn_ = now;
  write_(terminal_ ? "\r" + line(now) + "\x1b[K" : line(now) + "\n");
}

void ProgressBar::finish() {
  const std::lock_guard lock(mutex_);
  end_stage(clock_());
  stage_.clear();
}

void ProgressBar::end_stage(double now) {
  if (stage_.empty()) return;
  const double took = now - begin_;
  if (terminal_) {
    write_(fmt::format("\r{:<24} {}\x1b[K\n", stage_, duration_text(took)));
  } else if (took >= kWorthALine) {
    write_(fmt::format("{}: {}\n", stage_, duration_text(took)));
  }
}

std::string ProgressBar::line(double now) const {
  const double elapsed = now - begin_;
  if (total_ == 0) return fmt::format("{:<24} {}", stage_, duration_text(elapsed));
  const double share = std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
  const std::string left =
      share > 0 && elapsed > 1 ? ", " + duration_text(elapsed * (1 - share) / share) + " left" : "";
  if (!terminal_) return fmt::format("{}: {:.0f} %{}", stage_, 100 * share, left);
  const auto filled = static_cast<std::size_t>(std::lround(share * kBarWidth));
  return fmt::format("{:<24} [{}{}] {:3.0f} %{}", stage_, std::string(filled, '#'),
                     std::string(kBarWidth - filled, '.'), 100 * share, left);
}

}  // namespace obscura
