// The program's commands: each declares its options on a CLI11 subcommand and returns what runs it.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace obscura::cli {

struct Command {
  CLI::App* app;
  std::function<int()> run;  ///< @returns the exit code; throws what octree/base/error.h holds
};

Command add_render(CLI::App& program);
Command add_info(CLI::App& program);
Command add_convert(CLI::App& program);
Command add_compare(CLI::App& program);
Command add_export(CLI::App& program);
Command add_schema(CLI::App& program);
Command add_verify(CLI::App& program);
Command add_obscuration(CLI::App& program);
Command add_study(CLI::App& program);
Command add_plan(CLI::App& program);

/// Commands that will come.
const std::vector<std::string>& later_commands();

/// Reads the command line and runs one command. Prints errors. @returns the exit code
int run_program(int argc, char** argv);

}  // namespace obscura::cli
