// The sub-commands of `vergence`. Each registers itself; main maps exceptions to exit statuses.
#pragma once

#include <CLI/CLI.hpp>

namespace vergence::tools {

void add_estimate_command(CLI::App& app);
void add_fitness_map_command(CLI::App& app);
void add_model_command(CLI::App& app);
void add_render_command(CLI::App& app);
void add_bench_command(CLI::App& app);
CLI::App* add_bench_rt_command(CLI::App& bench);
void add_accuracy_command(CLI::App& app);
void add_demo_command(CLI::App& app);
void add_bringup_command(CLI::App& app);
void add_config_command(CLI::App& app);
void add_controller_commands(CLI::App& app);
void add_calibrate_command(CLI::App& app);
void add_replay_command(CLI::App& app);

}  // namespace vergence::tools
