// The accuracy page, Markdown; and the table of claims for the terminal.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "tools/accuracy/suite.hpp"

namespace vergence::accuracy {

void print_claims(std::ostream& out, const std::vector<Claim>& claims);

// Everything measured, with its figures, which stand in `figures` and are linked as `figures_link`. Throws
// InputError where it cannot be written.
void write_page(const std::filesystem::path& page, const SuiteResult& result, const SuiteOptions& options,
                const std::string& figures_link);

}  // namespace vergence::accuracy
