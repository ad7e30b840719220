// Bytes as text, to put pictures into a page (RFC 4648, with padding).
#pragma once

#include <string>
#include <string_view>

namespace vergence::tools {

[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace vergence::tools
