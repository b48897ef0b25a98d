// Reads the reference tables: lines starting with '#' are comments, then one header line, then rows
// of comma-separated fields without quotes. Numbers by strtod: 1e-1240 is 0, "inf" and "nan" are
// read.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace obscura::test {

class Csv {
 public:
  /// @throws std::runtime_error where the file cannot be read or a row has a wrong number of fields
  explicit Csv(const std::string& path) : path_(path) {
    std::ifstream file(path);
    if (!file) throw std::runtime_error("cannot open " + path);
    std::string line;
    while (std::getline(file, line)) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (line.empty() || line.front() == '#') continue;
      std::vector<std::string> fields = split(line, ',');
      if (header_.empty()) {
        header_ = std::move(fields);
      } else if (fields.size() == header_.size()) {
        rows_.push_back(std::move(fields));
      } else {
        throw std::runtime_error(path + ": " + line + ": wrong number of fields");
      }
    }
  }

  std::size_t size() const { return rows_.size(); }

  bool has(const std::string& column) const {
    return std::find(header_.begin(), header_.end(), column) != header_.end();
  }
  const std::string& text(std::size_t row, const std::string& column) const {
    for (std::size_t i = 0; i < header_.size(); ++i) {
      if (header_[i] == column) return rows_.at(row)[i];
    }
    throw std::runtime_error(path_ + " has no column " + column);
  }
  /// 0 for an empty field.
  double number(std::size_t row, const std::string& column) const {
    return std::strtod(text(row, column).c_str(), nullptr);
  }
  /// A field that holds several numbers separated by spaces.
  std::vector<double> numbers(std::size_t row, const std::string& column) const {
    std::vector<double> result;
    for (const std::string& word : split(text(row, column), ' ')) {
      if (!word.empty()) result.push_back(std::strtod(word.c_str(), nullptr));
    }
    return result;
  }

 private:
  static std::vector<std::string> split(const std::string& line, char separator) {
    std::vector<std::string> fields(1);
    for (const char c : line) {
      if (c == separator)
        fields.emplace_back();
      else
        fields.back() += c;
    }
    return fields;
  }

  std::string path_;
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace obscura::test
