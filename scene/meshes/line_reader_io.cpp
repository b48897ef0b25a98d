#include "scene/meshes/line_reader_io.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cstring>

#include "octree/base/error.h"
#include "scene/file/scene_table_io.h"

namespace obscura::detail {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 20;
constexpr std::size_t kLongestLine = std::size_t{1} << 28;
constexpr const char* kBlanks = " \t\r";

template <class T>
bool parse(std::string_view word, T& number) noexcept {
  if (word.size() > 1 && word[0] == '+') word.remove_prefix(1);
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc() && rest == word.data() + word.size();
}

}  // namespace

struct LineReader::Stream {
  gzFile file = nullptr;
  ~Stream() {
    if (file) gzclose(file);
  }
};

LineReader::LineReader(const std::filesystem::path& file) : file_(file), stream_(std::make_unique<Stream>()) {
  if (const std::string why = why_unreadable(file); !why.empty()) {
    throw InputError(file.string(), why, "check the name and the permissions");
  }
  stream_->file = gzopen(file.c_str(), "rb");
  if (!stream_->file) throw InputError(file.string(), "it cannot be opened", "check the name and the permissions");
  gzbuffer(stream_->file, kChunk);
  buffer_.resize(kChunk);
}

LineReader::~LineReader() = default;

// Appends to the buffer what comes next; false at the file's end.
bool LineReader::fill() {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ == buffer_.size()) {
    if (buffer_.size() >= kLongestLine) {
      ++line_;
      fail(fmt::format("the line is longer than {} MiB", kLongestLine >> 20), "this is no text of the expected kind");
    }
    buffer_.resize(2 * buffer_.size());
  }
  const int count = gzread(stream_->file, buffer_.data() + end_, static_cast<unsigned>(buffer_.size() - end_));
  int error = Z_OK;
  const char* what = gzerror(stream_->file, &error);
  if (count < 0 || (error != Z_OK && error != Z_STREAM_END)) {
    if (error == Z_ERRNO) throw InputError(file_.string(), "it could not be read to its end", "check the disk");
    throw InputError(file_.string(), fmt::format("its gzip data are broken or cut off ({})", what),
                     "copy or pack the file anew");
  }
  end_ += static_cast<std::size_t>(count);
  return count > 0;
}

bool LineReader::next(std::string_view& line) {
  std::size_t searched = begin_;
  while (true) {
    const void* end = std::memchr(buffer_.data() + searched, '\n', end_ - searched);
    if (end) {
      const std::size_t at = static_cast<std::size_t>(static_cast<const char*>(end) - buffer_.data());
      line = {buffer_.data() + begin_, at - begin_};
      begin_ = at + 1;
      break;
    }
    searched = end_ - begin_;
    if (fill()) continue;
    if (begin_ == end_) return false;
    line = {buffer_.data() + begin_, end_ - begin_};
    begin_ = end_;
    break;
  }
  ++line_;
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  if (line_ == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") line.remove_prefix(3);
  return true;
}

bool LineReader::next_filled(std::string_view& line) {
  while (next(line)) {
    line = without_blanks(line);
    if (!line.empty()) return true;
  }
  return false;
}

std::size_t LineReader::read(void* bytes, std::size_t count) {
  std::size_t done = 0;
  while (done < count) {
    if (begin_ == end_ && !fill()) break;
    const std::size_t part = std::min(count - done, end_ - begin_);
    std::memcpy(static_cast<char*>(bytes) + done, buffer_.data() + begin_, part);
    begin_ += part;
    done += part;
  }
  return done;
}

void LineReader::fail(const std::string& problem, const std::string& hint) const {
  throw InputError(line_ > 0 ? fmt::format("{}, line {}", file_.string(), line_) : file_.string(), problem, hint);
}

std::string_view next_word(std::string_view& text) noexcept {
  const std::size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
  const std::size_t end = std::min(text.find_first_of(kBlanks, begin), text.size());
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

std::string_view without_blanks(std::string_view text) noexcept {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

bool to_number(std::string_view word, double& number) noexcept { return parse(word, number); }
bool to_number(std::string_view word, std::int64_t& number) noexcept { return parse(word, number); }

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

}  // namespace obscura::detail
