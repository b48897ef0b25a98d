#include "scene/file/scene_schema.h"

#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <type_traits>

#include "scene/file/scene_keys.h"

namespace obscura {
namespace detail {
namespace {

// The values that count as "not given".
Json absent_values() { return Json::array({nullptr, Json::object(), Json::array()}); }

Json number_schema(const char* type, const Limits& limits) {
  Json schema = {{"type", type}};
  const auto plain = [](double value) {
    return value == std::floor(value) && std::abs(value) < 9e15 ? Json(static_cast<std::int64_t>(value)) : Json(value);
  };
  if (limits.min > -kInfinity) schema[limits.above_min ? "exclusiveMinimum" : "minimum"] = plain(limits.min);
  if (limits.max < kInfinity) schema[limits.below_max ? "exclusiveMaximum" : "maximum"] = plain(limits.max);
  return schema;
}

Json list_schema(Json items, std::size_t min_items, std::size_t max_items) {
  Json schema = {{"type", "array"}, {"items", std::move(items)}};
  if (min_items > 0) schema["minItems"] = min_items;
  if (max_items > 0) schema["maxItems"] = max_items;
  return schema;
}

Json nullable(Json schema) {
  if (schema.contains("anyOf")) {
    schema["anyOf"].push_back({{"type", "null"}});
  } else if (schema.contains("enum")) {
    schema["enum"].push_back(nullptr);
  } else if (schema.contains("type")) {
    schema["type"] = Json::array({schema["type"], "null"});
  } else {
    schema = {{"anyOf", Json::array({std::move(schema), {{"type", "null"}}})}};
  }
  return schema;
}

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};
template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};

template <class T>
struct IsMap : std::false_type {};
template <class T>
struct IsMap<std::map<std::string, T>> : std::true_type {};

template <class T>
Json object_schema();

template <class T>
Json spectral_schema(const Limits& limits) {
  Json table = {{"type", "object"},
                {"properties",
                 {{"um", list_schema(number_schema("number", above(0)), 1, 0)},
                  {"value", list_schema(number_schema("number", limits), 1, 0)},
                  {"file", {{"type", "null"}}}}},
                {"required", {"um", "value"}},
                {"additionalProperties", false}};
  Json file = {
      {"type", "object"},
      {"properties",
       {{"file", {{"type", "string"}, {"minLength", 1}}}, {"um", {{"type", "null"}}}, {"value", {{"type", "null"}}}}},
      {"required", Json::array({"file"})},
      {"additionalProperties", false}};
  return {{"anyOf", Json::array({number_schema("number", limits), std::move(table), std::move(file)})}};
}

template <class T>
Json schema_of(const Limits& limits) {
  if constexpr (IsOptional<T>::value) {
    return schema_of<typename T::value_type>(limits);
  } else if constexpr (std::is_same_v<T, double>) {
    return number_schema("number", limits);
  } else if constexpr (std::is_same_v<T, bool>) {
    return {{"type", "boolean"}};
  } else if constexpr (std::is_integral_v<T>) {
    return number_schema("integer", limits);
  } else if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, std::filesystem::path>) {
    if (!limits.names.empty()) return {{"enum", limits.names}};
    return {{"type", "string"}, {"minLength", 1}};
  } else if constexpr (std::is_same_v<T, Spectrum>) {
    return spectral_schema<T>(limits);
  } else if constexpr (std::is_same_v<T, ErrorTarget>) {
    Json text = {{"type", "string"}, {"pattern", "^[0-9.eE+-]+ *(%|K|mK)?$"}};
    return {{"anyOf", Json::array({number_schema("number", inside(0, 1)), std::move(text)})}};
  } else if constexpr (std::is_same_v<T, Vec3d>) {
    return list_schema(number_schema("number", limits), 3, 3);
  } else if constexpr (std::is_same_v<T, std::array<double, 2>>) {
    return list_schema(number_schema("number", limits), 2, 2);
  } else if constexpr (std::is_same_v<T, std::array<int, 2>>) {
    return list_schema(number_schema("integer", limits), 2, 2);
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    return list_schema(number_schema("number", limits), limits.min_items, 0);
  } else if constexpr (IsMap<T>::value) {
    Json schema = {{"type", "object"}, {"additionalProperties", nullable(schema_of<typename T::mapped_type>(any()))}};
    if (!limits.names.empty()) schema["propertyNames"] = {{"enum", limits.names}};
    return schema;
  } else if constexpr (IsVector<T>::value) {
    return list_schema(schema_of<typename T::value_type>(any()), limits.min_items, 0);
  } else if constexpr (std::is_enum_v<T>) {
    Json words = Json::array();
    for (const auto& word : Words<T>::list) {
      if (!word.later) words.push_back(word.text);
    }
    return {{"enum", std::move(words)}};
  } else {
    return object_schema<T>();
  }
}

// The default as JSON; null where it is no plain value.
template <class T>
Json default_of(const T& value) {
  if constexpr (std::is_same_v<T, std::string>) {
    return value.empty() ? Json(nullptr) : Json(value);
  } else if constexpr (std::is_integral_v<T> || std::is_same_v<T, double>) {
    return value;
  } else if constexpr (std::is_same_v<T, Vec3d>) {
    return Json::array({value.x, value.y, value.z});
  } else if constexpr (std::is_same_v<T, std::array<int, 2>> || std::is_same_v<T, std::array<double, 2>>) {
    return Json(value);
  } else if constexpr (std::is_same_v<T, Spectrum>) {
    return value.nodes_um().empty() ? Json(value.values()[0]) : Json(nullptr);
  } else if constexpr (std::is_enum_v<T>) {
    for (const auto& word : Words<T>::list) {
      if (word.value == value) return word.text;
    }
    return nullptr;
  } else {
    return nullptr;
  }
}

/// The visitor of scene_keys.h that writes down what the reader would read.
class ObjectSchema {
 public:
  template <class T>
  void required(const char* key, T&, const Limits& limits, const std::string& what) {
    add(key, schema_of<T>(limits), what);
    part().required.push_back(key);
  }

  template <class T>
  void optional(const char* key, T& member, const Limits& limits, const std::string& what) {
    Json schema = nullable(schema_of<T>(limits));
    if constexpr (IsOptional<T>::value) {
      if constexpr (requires(ObjectSchema & v, typename T::value_type & object) { keys(v, object); }) {
        Json empty = {{"type", "object"}, {"maxProperties", 0}};
        schema = {{"anyOf", Json::array({std::move(schema), std::move(empty)})}};
      }
    }
    if (Json value = default_of(member); !value.is_null()) schema["default"] = std::move(value);
    add(key, std::move(schema), what);
  }

  bool later(const char* key, const Json& default_value, const char* what) {
    Json values = absent_values();
    if (!default_value.is_null() && !default_value.empty()) values.insert(values.begin(), default_value);
    add(key, {{"enum", std::move(values)}}, std::string(what) + " (not available yet)");
    return false;
  }

  void skip(const char*) {}

  void form(const char* key) { forms_.push_back({key, {}, {}}); }
  void form(const char* key, const char* word) {
    forms_.push_back({key, {}, {}});
    add(key, {{"enum", Json::array({word})}}, "");
    part().required.push_back(key);
  }
  void default_form(const char* key, const char* word) {
    forms_.push_back({key, {}, {}});
    add(key, {{"enum", Json::array({word, nullptr})}}, "");
  }
  void every_form() { in_form_ = false; }

  template <class T>
  void sets(T&, T) {}
  template <class T, class Make>
  void makes(T&, const Make&) {}

  void exactly_one(std::initializer_list<const char*> names) {
    Json choices = Json::array();
    for (const char* chosen : names) {
      Json properties = Json::object();
      for (const char* name : names) {
        properties[name] = {{"enum", absent_values()}};
        if (name == chosen) properties[name] = {{"not", properties[name]}};
      }
      choices.push_back({{"required", Json::array({chosen})}, {"properties", std::move(properties)}});
    }
    part().choices = std::move(choices);
  }

  void phase_table(const PhaseTableDescription&, PhaseFunction&) {}
  void periods(const std::vector<Axis>&, const std::vector<double>&, CloudDescription&) {}
  void angle_factor(const std::vector<double>&, const std::vector<double>&, MaterialDescription&) {}
  void point_spread(const std::filesystem::path&, DetectorSettings&) {}
  void particles(const ParticlesDescription&, std::vector<ParticleDescription>&) {}

  Json finish() const {
    if (forms_.empty()) return object(common_, nullptr);
    Json branches = Json::array();
    for (const Part& form : forms_) branches.push_back(object(common_, &form));
    return {{"anyOf", std::move(branches)}};
  }

 private:
  struct Part {
    std::string tag;
    Json properties = Json::object();
    std::vector<std::string> required;
    Json choices = nullptr;
  };

  Part& part() { return in_form_ && !forms_.empty() ? forms_.back() : common_; }

  void add(const char* key, Json schema, const std::string& what) {
    if (!what.empty()) schema["description"] = what;
    part().properties[key] = std::move(schema);
  }

  // The schema of an object in one of its forms (null: it has only one). Keys of the other forms may be there as null.
  Json object(const Part& common, const Part* form) const {
    Json properties = form ? form->properties : Json::object();
    for (const auto& [key, schema] : common.properties.items()) properties[key] = schema;
    for (const Part& other : forms_) {
      for (const auto& [key, ignored] : other.properties.items()) {
        if (!properties.contains(key)) properties[key] = {{"type", "null"}};
      }
    }
    std::vector<std::string> required = form ? form->required : std::vector<std::string>{};
    required.insert(required.end(), common.required.begin(), common.required.end());
    Json schema = {{"type", "object"}, {"properties", std::move(properties)}};
    if (!required.empty()) schema["required"] = required;
    schema["additionalProperties"] = false;
    if (!common.choices.is_null()) schema["oneOf"] = common.choices;
    if (form && !form->choices.is_null()) schema["oneOf"] = form->choices;
    return schema;
  }

  Part common_;
  std::vector<Part> forms_;
  bool in_form_ = true;
};

template <class T>
Json object_schema() {
  ObjectSchema visitor;
  T object{};
  keys(visitor, object);
  return visitor.finish();
}

}  // namespace
}  // namespace detail

std::string scene_schema() {
  detail::Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                         {"title", "Obscura scene, version 1"}};
  schema.update(detail::object_schema<Description>());
  return schema.dump(1) + '\n';
}

}  // namespace obscura
