#include "tools/io/toml_reader.hpp"

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>

#include "tools/io/input_error.hpp"

namespace vergence::tools {
namespace {

std::string shown(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

std::string range_text(Range range) {
  if (range.low == kPositive.low && range.high == kPositive.high) return "must be above 0";
  return "must lie in [" + shown(range.low) + ", " + shown(range.high) + "]";
}

void merge(toml::table& into, const toml::table& patch) {
  for (const auto& [key, node] : patch) {
    toml::table* old = into[key.str()].as_table();
    if (old != nullptr && node.is_table()) {
      merge(*old, *node.as_table());
    } else {
      into.insert_or_assign(key.str(), node);
    }
  }
}

toml::table parse_patch(const std::filesystem::path& file, const std::string& patch) {
  try {
    return toml::parse(patch);
  } catch (const toml::parse_error& error) {
    throw InputError(file, "change '" + patch + "'", std::string(error.description()),
                     "not valid TOML; a text needs quotes: light.preset = \"30lx\"");
  }
}

}  // namespace

TomlReader::TomlReader(std::filesystem::path file, std::string prefix,
                       std::shared_ptr<const toml::table> root, const toml::table* table)
    : file_(std::move(file)), prefix_(std::move(prefix)), root_(std::move(root)), table_(table) {}

TomlReader TomlReader::from_file(const std::filesystem::path& file, const std::string& patch) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored))
    throw InputError(file, "", "no such file", "expected a TOML file there");
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  if (!in) throw InputError(file, "", "cannot be read");
  return from_text(file, text.str(), patch);
}

TomlReader TomlReader::from_text(const std::filesystem::path& name, const std::string& text,
                                 const std::string& patch) {
  try {
    auto parsed = std::make_shared<toml::table>(toml::parse(text));
    if (!patch.empty()) merge(*parsed, parse_patch(name, patch));
    std::shared_ptr<const toml::table> root = std::move(parsed);
    const toml::table* table = root.get();
    return {name, "", std::move(root), table};
  } catch (const toml::parse_error& error) {
    throw InputError(name, "line " + std::to_string(error.source().begin.line),
                     std::string(error.description()), "not valid TOML");
  }
}

std::string TomlReader::field(std::string_view key) const {
  return prefix_.empty() ? std::string(key) : prefix_ + "." + std::string(key);
}

void TomlReader::fail(std::string_view key, const std::string& problem, const std::string& remedy) const {
  std::string where = field(key);
  if (const toml::node* node = table_ == nullptr ? nullptr : table_->get(key)) {
    where = "line " + std::to_string(node->source().begin.line) + ": " + where;
  } else if (table_ != nullptr && !prefix_.empty() && table_->source().begin.line > 0) {
    where = "line " + std::to_string(table_->source().begin.line) + ": " + where;  // where it is missing
  }
  throw InputError(file_, where, problem, remedy);
}

bool TomlReader::has(std::string_view key) const {
  return table_ != nullptr && table_->contains(key);
}

const toml::node& TomlReader::required(std::string_view key, const std::string& expected) const {
  const toml::node* node = table_ == nullptr ? nullptr : table_->get(key);
  if (node == nullptr) fail(key, "missing", "expected " + expected);
  return *node;
}

double TomlReader::number(std::string_view key, Range range) const {
  const auto value = required(key, "a number").value<double>();
  if (!value) fail(key, "is not a number");
  if (!std::isfinite(*value)) fail(key, "is not a finite number");
  if (*value < range.low || *value > range.high)
    fail(key, "is " + shown(*value) + " but " + range_text(range));
  return *value;
}

double TomlReader::number_or(std::string_view key, double fallback, Range range) const {
  return has(key) ? number(key, range) : fallback;
}

int TomlReader::integer(std::string_view key, int low, int high) const {
  const double value = number(key, {static_cast<double>(low), static_cast<double>(high)});
  if (value != std::floor(value)) fail(key, "is " + shown(value) + " but must be a whole number");
  return static_cast<int>(value);
}

int TomlReader::integer_or(std::string_view key, int fallback, int low, int high) const {
  return has(key) ? integer(key, low, high) : fallback;
}

bool TomlReader::boolean_or(std::string_view key, bool fallback) const {
  if (!has(key)) return fallback;
  const auto value = required(key, "true or false").value<bool>();
  if (!value) fail(key, "is neither true nor false");
  return *value;
}

std::string TomlReader::text(std::string_view key) const {
  const auto value = required(key, "a text").value<std::string>();
  if (!value) fail(key, "is not a text", "put it in quotes");
  return *value;
}

std::string TomlReader::text_or(std::string_view key, const std::string& fallback) const {
  return has(key) ? text(key) : fallback;
}

std::vector<double> TomlReader::numbers(std::string_view key, std::size_t count) const {
  const toml::array* array = required(key, "a list of numbers").as_array();
  if (array == nullptr) fail(key, "is not a list of numbers");
  if (count != 0 && array->size() != count) {
    fail(key, "has " + std::to_string(array->size()) + " numbers but must have " + std::to_string(count));
  }
  std::vector<double> values;
  for (const toml::node& node : *array) {
    const auto value = node.value<double>();
    if (!value) fail(key, "holds something that is not a number");
    if (!std::isfinite(*value)) fail(key, "holds a number that is not finite");
    values.push_back(*value);
  }
  return values;
}

TomlReader TomlReader::table(std::string_view key) const {
  const toml::table* table = required(key, "a table [" + field(key) + "]").as_table();
  if (table == nullptr) fail(key, "is not a table");
  return {file_, field(key), root_, table};
}

TomlReader TomlReader::table_or_empty(std::string_view key) const {
  if (has(key)) return table(key);
  return {file_, field(key), root_, nullptr};
}

std::vector<TomlReader> TomlReader::tables(std::string_view key, bool may_be_missing) const {
  std::vector<TomlReader> result;
  if (may_be_missing && !has(key)) return result;
  const toml::array* array = required(key, "tables [[" + field(key) + "]]").as_array();
  if (array == nullptr) fail(key, "is not a list of tables", "write [[" + field(key) + "]]");
  for (const toml::node& node : *array) {
    const toml::table* table = node.as_table();
    if (table == nullptr) fail(key, "holds something that is not a table");
    result.push_back({file_, field(key) + "[" + std::to_string(result.size()) + "]", root_, table});
  }
  if (result.empty()) fail(key, "is empty");
  return result;
}

void TomlReader::allow_only(std::initializer_list<std::string_view> keys) const {
  allow_only(std::vector<std::string_view>(keys));
}

void TomlReader::allow_only(const std::vector<std::string_view>& keys) const {
  if (table_ == nullptr) return;
  for (const auto& [key, node] : *table_) {
    if (std::find(keys.begin(), keys.end(), key.str()) != keys.end()) continue;
    std::string known;
    for (const std::string_view k : keys) known += (known.empty() ? "" : ", ") + std::string(k);
    fail(key.str(), "is not a known key", "known here: " + known);
  }
}

}  // namespace vergence::tools
