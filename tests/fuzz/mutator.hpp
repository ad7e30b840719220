// Deterministic damage to bytes, as a fuzzer does it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace vergence::test {

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : state_(seed) {}

  // One to four changes: bytes flipped, dropped, doubled, or replaced by a word that parsers trip over.
  std::string mutate(std::string text) {
    for (std::uint64_t changes = 1 + below(4); changes > 0; --changes) change(text);
    return text;
  }

  std::uint64_t below(std::uint64_t bound) { return next() % bound; }

 private:
  // SplitMix64.
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }

  void change(std::string& text) {
    static constexpr std::string_view kWords[] = {
        "nan", "inf",  "-inf",   "-",  "0",  "-1",         "1e999",    "1e-320",  "99999999999999999999",
        "0.5", "true", "\"\"",   "[",  "]",  "{",          "}",        "=",       ",",
        "\n",  "#",    "\"\"\"", "[[", "]]", "2026-01-01", "\xff\xfe", "\\u0000", "0x7f"};
    if (text.empty()) {
      text = kWords[below(std::size(kWords))];
      return;
    }
    const std::size_t at = below(text.size());
    const std::size_t length = 1 + below(12);
    switch (below(6)) {
      case 0: text[at] = static_cast<char>(text[at] ^ (1 << below(8))); break;
      case 1: text[at] = static_cast<char>(below(256)); break;
      case 2: text.erase(at, length); break;
      case 3: text.insert(at, text.substr(below(text.size()), length)); break;
      case 4: text.replace(at, below(6), kWords[below(std::size(kWords))]); break;
      default:
        if (below(4) == 0) text.resize(at);
        break;
    }
  }

  std::uint64_t state_;
};

}  // namespace vergence::test
