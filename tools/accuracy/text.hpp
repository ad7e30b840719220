// Numbers as the accuracy page writes them.
#pragma once

#include <cstdio>
#include <string>

namespace vergence::accuracy {

template <class... Values>
[[nodiscard]] std::string format(const char* pattern, Values... values) {
  char text[512];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

}  // namespace vergence::accuracy
