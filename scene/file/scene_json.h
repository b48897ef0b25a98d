// JSON with comments as a tree in document order: parsing with places of errors, edits by JSON pointer,
// and a hash of the values. Knows no key of a scene.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "octree/base/error.h"

namespace obscura::detail {

using Json = nlohmann::ordered_json;

/// `/a/b` + `c`, with the escapes of RFC 6901.
std::string pointer_to(const std::string& parent, std::string_view key);
std::string pointer_to(const std::string& parent, std::size_t index);

/// Parses JSON; // and /* */ comments are white space. Keys that an object holds twice go to `problems`
/// (the last value stays).
/// @param name of the text, for messages
/// @throws InputError with line and column where the text is not JSON, or nested deeper than 100.
Json parse_json(std::string_view text, const std::string& name, std::vector<Problem>& problems);

/// Puts a value where the JSON pointer points, creating members (and one element at a list's end) that
/// are missing. @returns what is wrong with the pointer, empty if nothing.
std::string set_value(Json& document, const std::string& pointer, const Json& value);

/// JSON where the text is JSON, a string otherwise.
Json value_from_text(std::string_view text);

/// 16 hexadecimal digits (64-bit FNV-1a of the sorted, compact text); 1 and 1.0 are the same.
std::string hash_of(const Json& document);

/// "a number", "a list", ... for messages, with the value where it is short.
std::string describe_value(const Json& value);

}  // namespace obscura::detail
