// A validator for the part of JSON Schema that scene.schema.json uses; it throws on any other keyword, so
// that the schema cannot say something the tests do not check.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>
#include <string>

namespace obscura::test {

template <class Json>
bool has_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "number") return value.is_number();
  if (type == "boolean") return value.is_boolean();
  if (type == "null") return value.is_null();
  if (type == "integer") {
    return value.is_number() && value.template get<double>() == std::floor(value.template get<double>());
  }
  throw std::logic_error("the schema uses the type " + type);
}

template <class Json>
bool validates(const Json& schema, const Json& value) {
  for (const auto& [keyword, rule] : schema.items()) {
    bool good = true;
    if (keyword == "type") {
      good = false;
      for (const Json& type : rule.is_array() ? rule : Json::array({rule})) {
        good |= has_type(value, type.template get<std::string>());
      }
    } else if (keyword == "enum") {
      good = false;
      for (const Json& word : rule) good |= word == value;
    } else if (keyword == "minimum") {
      good = !value.is_number() || value >= rule;
    } else if (keyword == "maximum") {
      good = !value.is_number() || value <= rule;
    } else if (keyword == "exclusiveMinimum") {
      good = !value.is_number() || value > rule;
    } else if (keyword == "exclusiveMaximum") {
      good = !value.is_number() || value < rule;
    } else if (keyword == "minLength") {
      good = !value.is_string() || value.template get<std::string>().size() >= rule.template get<std::size_t>();
    } else if (keyword == "pattern") {
      good = !value.is_string() ||
             std::regex_search(value.template get<std::string>(), std::regex(rule.template get<std::string>()));
    } else if (keyword == "minItems") {
      good = !value.is_array() || value.size() >= rule.template get<std::size_t>();
    } else if (keyword == "maxItems") {
      good = !value.is_array() || value.size() <= rule.template get<std::size_t>();
    } else if (keyword == "maxProperties") {
      good = !value.is_object() || value.size() <= rule.template get<std::size_t>();
    } else if (keyword == "items") {
      if (value.is_array()) {
        for (const Json& item : value) good &= validates(rule, item);
      }
    } else if (keyword == "required") {
      if (value.is_object()) {
        for (const Json& key : rule) good &= value.contains(key.template get<std::string>());
      }
    } else if (keyword == "properties") {
      if (value.is_object()) {
        for (const auto& [key, sub] : rule.items()) good &= !value.contains(key) || validates(sub, value.at(key));
      }
    } else if (keyword == "additionalProperties") {
      if (value.is_object()) {
        for (const auto& [key, member] : value.items()) {
          if (schema.contains("properties") && schema.at("properties").contains(key)) continue;
          good &= rule.is_object() ? validates(rule, member) : rule.template get<bool>();
        }
      }
    } else if (keyword == "propertyNames") {
      if (value.is_object()) {
        for (const auto& [key, member] : value.items()) good &= validates(rule, Json(key));
      }
    } else if (keyword == "not") {
      good = !validates(rule, value);
    } else if (keyword == "anyOf" || keyword == "oneOf") {
      int count = 0;
      for (const Json& choice : rule) count += validates(choice, value) ? 1 : 0;
      good = keyword == "oneOf" ? count == 1 : count >= 1;
    } else if (keyword != "$schema" && keyword != "title" && keyword != "description" && keyword != "default") {
      throw std::logic_error("the schema uses the keyword " + keyword);
    }
    if (!good) return false;
  }
  return true;
}

}  // namespace obscura::test
