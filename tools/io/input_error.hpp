// Bad input of the user: what is wrong, where, and what to do about it. Ends the command with status 2.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace vergence::tools {

class InputError : public std::runtime_error {
 public:
  // Message "file: field: problem (remedy)"; field and remedy may be empty.
  InputError(const std::filesystem::path& file, const std::string& field, const std::string& problem,
             const std::string& remedy = "")
      : std::runtime_error(file.string() + ": " + (field.empty() ? "" : field + ": ") + problem +
                           (remedy.empty() ? "" : " (" + remedy + ")")) {}
};

}  // namespace vergence::tools
