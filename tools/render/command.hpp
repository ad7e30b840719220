// The sub-command `vergence render`.
#pragma once

#include <CLI/CLI.hpp>

namespace vergence::tools {

// Registers it; it runs when parsed. Throws InputError.
void add_render_command(CLI::App& app);

}  // namespace vergence::tools
