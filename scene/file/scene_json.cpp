#include "scene/file/scene_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace obscura::detail {
namespace {

constexpr std::size_t kMaxDepth = 100;

std::string line_and_column(std::string_view text, std::size_t byte) {
  const std::size_t end = std::min(byte, text.size());
  const auto before = text.substr(0, end);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t newline = before.rfind('\n');
  const std::size_t column = newline == std::string_view::npos ? end : end - newline - 1;
  return fmt::format("line {}, column {}", line, std::max<std::size_t>(1, column));
}

// Builds the tree from the parser's events. A finished tree does not show that a key was given twice: this does.
class TreeBuilder : public nlohmann::json_sax<Json> {
 public:
  TreeBuilder(std::string_view text, const std::string& name, std::vector<Problem>& problems)
      : text_(text), name_(name), problems_(problems) {}

  Json take() { return std::move(root_); }

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t&) override { return false; }

  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    Level& level = levels_.back();
    level.key = name;
    if (!level.keys.insert(name).second) {
      problems_.push_back({pointer_to(pointer(levels_.size() - 1), name),
                           fmt::format("the key \"{}\" is given twice", name), "keep one of them"});
    }
    return true;
  }

  bool parse_error(std::size_t byte, const std::string& token, const nlohmann::detail::exception& error) override {
    std::string what = error.what();  // "[json.exception.parse_error.101] parse error at line 1, column 2: ..."
    if (const auto colon = what.find(": "); colon != std::string::npos) what.erase(0, colon + 2);
    if (what.find("number overflow") != std::string::npos) what = "the number " + token + " is too large";
    throw InputError(fmt::format("{}: {}", name_, line_and_column(text_, byte)), "not valid JSON: " + what,
                     "correct the text there or just before");
  }

 private:
  struct Level {
    Json* node;
    std::string key;
    std::set<std::string> keys;
  };

  std::string pointer(std::size_t depth) const {
    std::string result;
    for (std::size_t i = 0; i < depth; ++i) {
      result = levels_[i].node->is_array() ? pointer_to(result, levels_[i].node->size() - 1)
                                           : pointer_to(result, levels_[i].key);
    }
    return result;
  }

  Json* place(Json value) {
    if (levels_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    Level& level = levels_.back();
    if (level.node->is_array()) {
      level.node->push_back(std::move(value));
      return &level.node->back();
    }
    Json& member = (*level.node)[level.key];
    member = std::move(value);
    return &member;
  }

  bool add(Json value) {
    place(std::move(value));
    return true;
  }

  // Pointers into the tree stay valid: a node's children are added only while it is the innermost level.
  bool open(Json value) {
    if (levels_.size() >= kMaxDepth) {
      throw InputError(name_, fmt::format("nested deeper than {} levels", kMaxDepth),
                       "a scene file needs fewer than 10");
    }
    Json* node = place(std::move(value));
    levels_.push_back({node, {}, {}});
    return true;
  }

  bool close() {
    levels_.pop_back();
    return true;
  }

  std::string_view text_;
  const std::string& name_;
  std::vector<Problem>& problems_;
  Json root_;
  std::vector<Level> levels_;
};

std::string unescape(std::string token) {
  for (std::size_t i = 0; i + 1 < token.size(); ++i) {
    if (token[i] == '~' && (token[i + 1] == '0' || token[i + 1] == '1')) {
      token.replace(i, 2, token[i + 1] == '0' ? "~" : "/");
    }
  }
  return token;
}

// The same tree with sorted keys and one spelling of each number.
nlohmann::json canonical(const Json& value) {
  if (value.is_object()) {
    nlohmann::json result = nlohmann::json::object();
    for (const auto& [key, member] : value.items()) result[key] = canonical(member);
    return result;
  }
  if (value.is_array()) {
    nlohmann::json result = nlohmann::json::array();
    for (const Json& element : value) result.push_back(canonical(element));
    return result;
  }
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (number == std::floor(number) && std::abs(number) < 9e15) return static_cast<std::int64_t>(number);
    return number;
  }
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_string()) return value.get<std::string>();
  return nullptr;
}

}  // namespace

std::string pointer_to(const std::string& parent, std::string_view key) {
  std::string result = parent + '/';
  for (const char c : key) {
    if (c == '~') {
      result += "~0";
    } else if (c == '/') {
      result += "~1";
    } else {
      result += c;
    }
  }
  return result;
}

std::string pointer_to(const std::string& parent, std::size_t index) { return parent + '/' + std::to_string(index); }

Json parse_json(std::string_view text, const std::string& name, std::vector<Problem>& problems) {
  TreeBuilder builder(text, name, problems);
  Json::sax_parse(text.begin(), text.end(), &builder, nlohmann::detail::input_format_t::json,
                  /*strict=*/true, /*ignore_comments=*/true);
  return builder.take();
}

std::string set_value(Json& document, const std::string& pointer, const Json& value) {
  if (pointer.empty() || pointer[0] != '/') return "a JSON pointer begins with \"/\"";
  Json* node = &document;
  std::size_t begin = 1;
  while (true) {
    const std::size_t end = std::min(pointer.find('/', begin), pointer.size());
    const std::string token = unescape(pointer.substr(begin, end - begin));
    if (node->is_null()) *node = Json::object();
    if (node->is_array()) {
      const bool digits = !token.empty() && token.size() < 10 &&
                          std::all_of(token.begin(), token.end(), [](char c) { return c >= '0' && c <= '9'; });
      const std::size_t index = token == "-" ? node->size() : digits ? std::stoul(token) : node->size() + 1;
      if (index > node->size()) {
        return fmt::format("\"{}\" is no element of a list of {}", token, node->size());
      }
      if (index == node->size()) node->push_back(nullptr);
      node = &(*node)[index];
    } else if (node->is_object()) {
      if (token.empty()) return "a key is missing between two \"/\"";
      node = &(*node)[token];
    } else {
      return fmt::format("there is nothing below {}, which is {}", pointer.substr(0, begin - 1), describe_value(*node));
    }
    if (end == pointer.size()) break;
    begin = end + 1;
  }
  *node = value;
  return {};
}

Json value_from_text(std::string_view text) {
  try {
    std::vector<Problem> problems;
    Json value = parse_json(text, "", problems);
    if (problems.empty()) return value;
  } catch (const InputError&) {
  }
  return std::string(text);
}

std::string hash_of(const Json& document) {
  const std::string text = canonical(document).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  std::uint64_t hash = 0xCBF29CE484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return fmt::format("{:016x}", hash);
}

std::string describe_value(const Json& value) {
  const auto shortened = [&] {
    std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (text.size() > 40) text = text.substr(0, 37) + "...";
    return text;
  };
  if (value.is_object()) return value.empty() ? "an empty object {}" : "an object {...}";
  if (value.is_array())
    return value.size() <= 4 ? "the list " + shortened() : fmt::format("a list of {}", value.size());
  if (value.is_string()) return "the text " + shortened();
  if (value.is_null()) return "null";
  return shortened();
}

}  // namespace obscura::detail
