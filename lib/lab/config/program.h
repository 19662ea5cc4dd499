#pragma once

#include <CLI/CLI.hpp>

#include <atomic>
#include <csignal>
#include <functional>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "diffsac/core/nearest_word.h"
#include "diffsac/core/status.h"
#include "lab/config/process.h"

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

/// Checks of numbers on a command line. CLI11's own print the ends of their ranges with all their digits, of doubles
/// 309.
inline CLI::Validator NumberCheck(const std::string& expected, bool (*good)(double value, double low, double high),
                                  double low, double high) {
  return CLI::Validator(
      [=](std::string& text) {
        double value = 0.0;
        const bool number = CLI::detail::lexical_cast(text, value);
        return number && good(value, low, high) ? "" : "expected " + expected + ", found '" + text + "'";
      },
      "");
}

/// A number as a person writes it: "0", "0.5", "1024".
inline std::string PlainNumber(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

inline CLI::Validator NumberAbove(double low) {
  return NumberCheck(
      "a number above " + PlainNumber(low), [](double v, double l, double) { return v > l; }, low, low);
}

inline CLI::Validator NumberFrom(double low) {
  return NumberCheck(
      "a number from " + PlainNumber(low) + " on", [](double v, double l, double) { return v >= l; }, low, low);
}

inline CLI::Validator NumberWithin(double low, double high) {
  return NumberCheck(
      "a number from " + PlainNumber(low) + " to " + PlainNumber(high),
      [](double v, double l, double h) { return v >= l && v <= h; }, low, high);
}

}  // namespace diffsac
