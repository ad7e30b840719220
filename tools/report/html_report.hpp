// The page a person reads after a run: what was done, how well it went beside the thesis, figures and
// pictures.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tools/report/metric.hpp"

namespace vergence::tools {

struct Picture {
  std::filesystem::path png;
  std::string caption;
};

struct ReportPage {
  std::string title;
  std::string description;  // a paragraph
  std::string command;      // the command line that gives the same run again
  Summary summary;
  std::vector<Picture> pictures;  // figures first, then what the cameras saw at the end
  std::vector<std::string> notes;
};

// One file that needs no other: pictures and style are inside. Texts are plain and may hold anything. Throws
// InputError where a picture is not a PNG or the page cannot be written.
void write_html_report(const std::filesystem::path& file, const ReportPage& page);

[[nodiscard]] std::string html_escaped(std::string_view text);

}  // namespace vergence::tools
