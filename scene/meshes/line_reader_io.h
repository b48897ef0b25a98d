// Text files of any length, line by line, with the line's number for messages; gzip is unpacked on the way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace obscura::detail {

/// A text file on its way from the first line to the last.
class LineReader {
 public:
  /// @throws InputError where the file cannot be opened
  explicit LineReader(const std::filesystem::path& file);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  /// The next line without its end; valid until the next call. @returns false at the end of the file
  bool next(std::string_view& line);
  /// The next line that is more than blanks, without blanks around it.
  bool next_filled(std::string_view& line);
  /// The next bytes as they are, which may follow lines. @returns how many there were
  std::size_t read(void* bytes, std::size_t count);

  std::size_t line() const noexcept { return line_; }  ///< number of the last line, from 1
  /// @throws InputError at the last line
  [[noreturn]] void fail(const std::string& problem, const std::string& hint) const;

 private:
  bool fill();

  std::filesystem::path file_;
  struct Stream;
  std::unique_ptr<Stream> stream_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::size_t line_ = 0;
};

/// Takes the first word off a text, which begins after it from then on. @returns the word; empty: there is none
std::string_view next_word(std::string_view& text) noexcept;
std::string_view without_blanks(std::string_view text) noexcept;
/// Reads a number that takes the whole word; "nan" and "inf" count as numbers. @returns false where it is none
bool to_number(std::string_view word, double& number) noexcept;
bool to_number(std::string_view word, std::int64_t& number) noexcept;
std::string lower_case(std::string_view text);

}  // namespace obscura::detail
