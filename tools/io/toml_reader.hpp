// Strict reading of TOML: every value typed, finite and in range, every complaint with file, line and field.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace toml {
inline namespace v3 {
class table;
class node;
}  // namespace v3
}  // namespace toml

namespace vergence::tools {

struct Range {
  double low = -std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::max();
};

inline constexpr Range kPositive{std::numeric_limits<double>::min(), std::numeric_limits<double>::max()};

// One table of a TOML file. All readers throw InputError.
class TomlReader {
 public:
  // Reads and parses a file. `patch` is TOML as well: what it says stands in place of what the file says,
  // table by table and key by key.
  static TomlReader from_file(const std::filesystem::path& file, const std::string& patch = "");
  // The same of a text; `name` stands for the file in complaints.
  static TomlReader from_text(const std::filesystem::path& name, const std::string& text,
                              const std::string& patch = "");

  [[nodiscard]] bool has(std::string_view key) const;

  // Required where no default is given.
  [[nodiscard]] double number(std::string_view key, Range range = {}) const;
  [[nodiscard]] double number_or(std::string_view key, double fallback, Range range = {}) const;
  [[nodiscard]] int integer(std::string_view key, int low, int high) const;
  [[nodiscard]] int integer_or(std::string_view key, int fallback, int low, int high) const;
  [[nodiscard]] bool boolean_or(std::string_view key, bool fallback) const;
  [[nodiscard]] std::string text(std::string_view key) const;
  [[nodiscard]] std::string text_or(std::string_view key, const std::string& fallback) const;
  // Finite numbers, exactly `count` of them (0: any count).
  [[nodiscard]] std::vector<double> numbers(std::string_view key, std::size_t count) const;
  [[nodiscard]] TomlReader table(std::string_view key) const;
  // The table, or an empty one.
  [[nodiscard]] TomlReader table_or_empty(std::string_view key) const;
  // [[key]]: at least one unless `may_be_missing`.
  [[nodiscard]] std::vector<TomlReader> tables(std::string_view key, bool may_be_missing = false) const;

  // Refuses keys nobody knows, so that a misspelt one is not silently ignored.
  void allow_only(std::initializer_list<std::string_view> keys) const;
  void allow_only(const std::vector<std::string_view>& keys) const;

  // A complaint about a field of this table.
  [[noreturn]] void fail(std::string_view key, const std::string& problem,
                         const std::string& remedy = "") const;

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  TomlReader(std::filesystem::path file, std::string prefix, std::shared_ptr<const toml::table> root,
             const toml::table* table);
  [[nodiscard]] std::string field(std::string_view key) const;
  [[nodiscard]] const toml::node& required(std::string_view key, const std::string& expected) const;

  std::filesystem::path file_;
  std::string prefix_;
  std::shared_ptr<const toml::table> root_;  // keeps the parsed file alive
  const toml::table* table_;
};

}  // namespace vergence::tools
