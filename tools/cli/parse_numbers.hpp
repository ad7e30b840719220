// Numbers in options.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace vergence::tools {

// Exactly `count` finite numbers, separated. Throws CLI::ValidationError naming the option.
[[nodiscard]] std::vector<double> parse_numbers(const std::string& option, const std::string& text,
                                                char separator, std::size_t count);

}  // namespace vergence::tools
