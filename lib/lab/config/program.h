#pragma once

#include <CLI/CLI.hpp>

#include <atomic>
#include <csignal>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "diffsac/core/nearest_word.h"
#include "diffsac/core/status.h"
#include "lab/config/exit_codes.h"

namespace diffsac {

/// Whether Ctrl-C or SIGTERM came after StopOnSignals.
inline std::atomic<bool> stop_requested{false};

inline void StopOnSignals() {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop_requested = true; });
}

/// "; did you mean '--focal'?" of words that are no options of the program or of the command that was given; empty
/// where there is no such word.
inline std::string NearestOptions(const CLI::App& app) {
  const CLI::App* command = app.get_subcommands().empty() ? &app : app.get_subcommands().front();
  std::vector<std::string> known;
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  std::string text;
  for (const std::string& word : app.remaining(true))
    if (word.starts_with("--")) text += "; did you mean '" + NearestWord(word.substr(0, word.find('=')), known) + "'?";
  return text;
}

/// What a program's main does: reads the arguments and runs. What is wrong is one line on stderr, which begins with the
/// program's name, and kExitBadInput.
inline int RunProgram(const std::string& name, CLI::App* app, int argc, char** argv, const std::function<int()>& run) {
  try {
    app->parse(argc, argv);
    return run();
  } catch (const CLI::Success& success) {
    return app->exit(success);
  } catch (const CLI::ExtrasError& error) {
    std::cerr << name << ": " << error.what() << NearestOptions(*app) << std::endl;
    return kExitBadInput;
  } catch (const std::exception& error) {
    std::cerr << name << ": " << MessageOf(error) << std::endl;
    return kExitBadInput;
  }
}

}  // namespace diffsac
