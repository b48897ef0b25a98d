// Progress and cancellation: long work tells how far it is and asks whether to go on. It neither
// prints nor reads a clock; who made it decides what is shown (see scene/).
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace obscura {

/// Handed down by const reference to every long-running call. Thread-safe.
class Progress {
 public:
  /// Told of the stage's name, the work done so far and the whole (0: not known), by several threads at once.
  using Listener = std::function<void(std::string_view stage, std::uint64_t done, std::uint64_t total)>;

  Progress() = default;
  /// @param cancelled may be set from a signal handler; null: never cancelled.
  Progress(Listener listener, const std::atomic<bool>* cancelled)
      : listener_(std::move(listener)), cancelled_(cancelled) {}

  void report(std::string_view stage, std::uint64_t done, std::uint64_t total) const {
    if (listener_) listener_(stage, done, total);
  }
  /// A Progress for one of `count` equal parts of a stage. What is reported to it shows as progress of this part
  /// under the stage's name, whatever name it is reported under. Copies the listener.
  Progress part(std::string stage, std::uint64_t index, std::uint64_t count) const {
    constexpr std::uint64_t steps = 1000;
    if (!listener_) return Progress(nullptr, cancelled_);
    return Progress(
        [listener = listener_, stage = std::move(stage), index, count](std::string_view, std::uint64_t done,
                                                                       std::uint64_t total) {
          listener(stage, index * steps + (total > 0 ? steps * std::min(done, total) / total : 0), count * steps);
        },
        cancelled_);
  }
  bool cancelled() const noexcept { return cancelled_ && cancelled_->load(std::memory_order_relaxed); }

 private:
  Listener listener_;
  const std::atomic<bool>* cancelled_ = nullptr;
};

}  // namespace obscura
