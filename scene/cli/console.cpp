#include "console.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>

namespace obscura::cli {
namespace {

std::atomic<bool> cancelled{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void on_interrupt(int signal) {
  if (cancelled.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
    return;
  }
  static const char text[] = "\nobscura: stopping; what there is will be written (again: quit at once)\n";
  [[maybe_unused]] const auto written = ::write(2, text, sizeof text - 1);
}

bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  if (std::filesystem::equivalent(a, b, error)) return true;
  return std::filesystem::absolute(a, error).lexically_normal() ==
         std::filesystem::absolute(b, error).lexically_normal();
}

}  // namespace

const std::atomic<bool>& cancel_flag() { return cancelled; }

void catch_interrupts() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}

Console::Console(bool quiet) {
  if (quiet) {
    progress_ = Progress(nullptr, &cancelled);
    return;
  }
  const auto clock = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  const auto write = [](std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
  };
  bar_ = std::make_unique<ProgressBar>(isatty(2) != 0, clock, write);
  progress_ = Progress([bar = bar_.get()](std::string_view stage, std::uint64_t done,
                                          std::uint64_t total) { bar->report(stage, done, total); },
                       &cancelled);
}

void Console::finish() {
  if (bar_) bar_->finish();
}

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) fmt::print(stderr, "warning: {}\n", warning);
}

void print_problems(const std::vector<Problem>& problems) {
  if (problems.size() > 1) fmt::print(stderr, "obscura: {} problems\n", problems.size());
  for (const Problem& problem : problems) {
    fmt::print(stderr, "{}{}\n", problems.size() > 1 ? "  " : "obscura: ", problem.text());
  }
}

void check_outputs(const std::vector<Output>& outputs, bool force, const std::vector<std::filesystem::path>& inputs,
                   std::vector<Problem> more) {
  std::vector<Problem> problems;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const auto& [file, option, extension] = outputs[i];
    const auto add = [&, &where = outputs[i].option](std::string problem, std::string hint) {
      problems.push_back({where, std::move(problem), std::move(hint)});
    };
    std::error_code error;
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    if (!extension.empty() && file.extension() != extension) {
      add(fmt::format("\"{}\" does not end in {}", file.string(), extension), "give a name that does");
    } else if (!std::filesystem::is_directory(folder, error)) {
      add(fmt::format("the folder \"{}\" does not exist", folder.string()), "create it, or name another");
    } else if (std::filesystem::is_directory(file, error)) {
      add(fmt::format("\"{}\" is a folder", file.string()), "name a file in it");
    } else {
      bool input = false, twice = false;
      for (const auto& path : inputs) input |= same_file(file, path);
      for (std::size_t j = 0; j < i; ++j) twice |= same_file(file, outputs[j].file);
      if (input) {
        add(fmt::format("\"{}\" would replace an input", file.string()), "give " + option + " another name");
      } else if (twice) {
        add(fmt::format("\"{}\" is the name of two outputs", file.string()), "give each its own");
      } else if (!force && std::filesystem::exists(file, error)) {
        add(fmt::format("\"{}\" exists", file.string()), "-f replaces it");
      }
    }
  }
  problems.insert(problems.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  if (!problems.empty()) throw InputError(std::move(problems));
  for (const Output& output : outputs) {
    const std::filesystem::path folder = output.file.has_parent_path() ? output.file.parent_path() : ".";
    if (access(folder.c_str(), W_OK) != 0) {
      throw ResourceError(output.option, fmt::format("the folder \"{}\" cannot be written to", folder.string()),
                          "change its permissions, or name another");
    }
  }
}

}  // namespace obscura::cli
