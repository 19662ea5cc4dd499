#pragma once

#include <CLI/CLI.hpp>

#include <atomic>
#include <csignal>
#include <functional>
#include <iostream>
#include <string>

#include "diffsac/core/status.h"
#include "lab/config/exit_codes.h"

namespace diffsac {

/// Whether Ctrl-C or SIGTERM came after StopOnSignals.
inline std::atomic<bool> stop_requested{false};

inline void StopOnSignals() {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop_requested = true; });
}

/// What a program's main does: reads the arguments and runs. What is wrong is one line on stderr, which begins with the
/// program's name, and kExitBadInput.
inline int RunProgram(const std::string& name, CLI::App* app, int argc, char** argv, const std::function<int()>& run) {
  try {
    app->parse(argc, argv);
    return run();
  } catch (const CLI::Success& success) {
    return app->exit(success);
  } catch (const std::exception& error) {
    std::cerr << name << ": " << MessageOf(error) << std::endl;
    return kExitBadInput;
  }
}

}  // namespace diffsac
