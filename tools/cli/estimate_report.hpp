// What `vergence estimate` says: a table for people, a line of JSON for machines, and a closing summary.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "tools/run/estimator.hpp"

namespace vergence::tools {

// A row of the table; the header comes with the first.
class EstimateTable {
 public:
  EstimateTable(std::ostream& out, bool with_error) : out_(out), with_error_(with_error) {}
  void print(const FrameResult& result);

 private:
  std::ostream& out_;
  bool with_error_;
  bool started_ = false;
};

// One JSON object, without line end, as in docs/formats.md.
[[nodiscard]] std::string to_json(const FrameResult& result, std::uint64_t seed);

void print_summary(std::ostream& out, const std::vector<FrameResult>& results);

}  // namespace vergence::tools
