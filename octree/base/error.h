// The three kinds of failure that a user may see; each says where, what and what to do about it.
// A broken invariant of the code itself is an assert, never one of these.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace obscura {

/// One mistake in what the user gave: where (file, JSON pointer, option), the problem, the remedy.
struct Problem {
  std::string where;
  std::string problem;
  std::string hint;

  /// "where: problem (hint)"
  std::string text() const;
};

/// Bad input, with every problem that was found (at least one). The program exits with 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<Problem> problems);
  InputError(std::string where, std::string problem, std::string hint = {});

  const std::vector<Problem>& problems() const noexcept { return problems_; }

 private:
  std::vector<Problem> problems_;
};

/// The world failed: disk, memory, permissions. The program exits with 3.
class ResourceError : public std::runtime_error {
 public:
  ResourceError(std::string where, std::string problem, std::string hint = {});
};

/// The numbers cannot be trusted: too many anomalies, or a method that refuses the scene by name.
/// The program exits with 4.
class NumericalError : public std::runtime_error {
 public:
  NumericalError(std::string where, std::string problem, std::string hint = {});
};

}  // namespace obscura
