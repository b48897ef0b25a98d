#include "scene/file/scene_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "scene/file/scene_keys.h"
#include "scene/file/scene_words.h"

namespace obscura::detail {
namespace {

bool is_empty(const Json& value) {
  return value.is_null() || ((value.is_object() || value.is_array()) && value.empty());
}

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string join(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, " | ")); }

}  // namespace

void Findings::problem(const std::string& pointer, std::string problem, std::string hint) {
  if (!told_.insert(pointer).second) return;
  problems.push_back({pointer, std::move(problem), std::move(hint)});
}

std::filesystem::path Findings::resolve(const std::string& name) const {
  return (base_folder_ / name).lexically_normal();
}

const Json* ObjectReader::find(std::string_view key) const {
  const auto it = object_.find(std::string(key));
  return it == object_.end() || it->is_null() ? nullptr : &*it;
}

bool ObjectReader::wanted(const char* key) {
  (in_form_ ? known_ : elsewhere_).emplace_back(key);
  return in_form_;
}

bool ObjectReader::later(const char* key, const Json& default_value, const char* what) {
  if (!wanted(key)) return false;
  const Json* value = find(key);
  if (!value || is_empty(*value) || *value == default_value) return false;
  findings_.problem(
      pointer_to(pointer_, key), fmt::format("\"{}\" ({}) is not available yet", key, what),
      is_empty(default_value) ? "leave it out" : "leave it out, or give its default " + default_value.dump());
  return true;
}

void ObjectReader::begin_form(Form form) {
  const bool taken = std::any_of(forms_.begin(), forms_.end(), [](const Form& f) { return f.matched; });
  in_form_ = form.matched && !taken;
  if (!form.word.empty()) wanted(form.key.c_str());
  forms_.push_back(std::move(form));
}

void ObjectReader::form(const char* key) { begin_form({key, {}, find(key) != nullptr}); }

void ObjectReader::form(const char* key, const char* word) {
  const Json* value = find(key);
  begin_form({key, word, value && *value == word});
}

void ObjectReader::default_form(const char* key, const char* word) {
  const Json* value = find(key);
  begin_form({key, word, !value || *value == word});
}

void ObjectReader::exactly_one(std::initializer_list<const char*> keys) {
  if (!in_form_) return;
  std::vector<std::string> given, all;
  for (const char* key : keys) {
    all.emplace_back(key);
    if (const Json* value = find(key); value && !is_empty(*value)) given.emplace_back(key);
  }
  if (given.empty()) missing_.push_back({all.front(), "give one of " + join(all)});
  if (given.size() > 1) {
    findings_.problem(pointer_to(pointer_, given[1]),
                      fmt::format("\"{}\" and \"{}\" are both given", given[0], given[1]),
                      "give exactly one of " + join(all));
  }
}

void ObjectReader::report_forms() {
  std::vector<std::string> tags, words;
  const Form* given = nullptr;
  for (const Form& form : forms_) {
    if (form.matched) return;
    if (!contains(tags, form.key)) tags.push_back(form.key);
    if (!form.word.empty() && find(form.key)) given = &form;
  }
  if (tags.empty()) return;
  if (!given) {
    missing_.push_back({tags.front(), "give one of " + join(tags)});
    return;
  }
  for (const Form& form : forms_) {
    if (form.key == given->key) words.push_back(form.word);
  }
  const Json& word = *find(given->key);
  const std::string pointer = pointer_to(pointer_, given->key);
  if (word.is_string()) {
    const std::string text = word.get<std::string>();
    findings_.problem(pointer, fmt::format("\"{}\" is not a word known here", text), suggest(text, words));
  } else {
    findings_.problem(pointer, "expected a word, found " + describe_value(word), "give one of " + join(words));
  }
}

void ObjectReader::finish() {
  report_forms();
  const auto form = std::find_if(forms_.begin(), forms_.end(), [](const Form& f) { return f.matched; });
  std::vector<std::string> valid = known_;
  if (form == forms_.end()) valid.insert(valid.end(), elsewhere_.begin(), elsewhere_.end());

  for (const auto& [key, value] : object_.items()) {
    if (contains(valid, key)) continue;
    const std::string pointer = pointer_to(pointer_, key);
    if (contains(elsewhere_, key)) {
      if (value.is_null()) continue;
      findings_.problem(pointer,
                        fmt::format("\"{}\" does not go with \"{}\"", key, form->word.empty() ? form->key : form->word),
                        "leave one of them out");
      continue;
    }
    findings_.problem(pointer, fmt::format("unknown key \"{}\"", key), suggest(key, valid));
    // A misspelt key is one mistake: the key that was meant is not told to be missing as well.
    const WordMatch nearest = nearest_word(key, valid);
    if (!nearest.close) continue;
    missing_.erase(
        std::remove_if(missing_.begin(), missing_.end(), [&](const Missing& m) { return m.key == nearest.word; }),
        missing_.end());
  }
  for (const Missing& m : missing_) {
    findings_.problem(pointer_to(pointer_, m.key), fmt::format("\"{}\" is missing", m.key), m.what);
  }
  if (findings_.problems.size() > problems_) return;
  for (const std::function<void()>& make : afterwards_) make();
}

void read_description(Findings& findings, const Json& document, Description& description) {
  read_value(findings, document, "", description, {});
}

}  // namespace obscura::detail
