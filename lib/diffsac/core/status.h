#pragma once

#include <exception>
#include <stdexcept>
#include <string>
#include <string_view>

namespace diffsac {

/// How an estimate ended. Estimators never throw for bad data: they return one of these.
enum class Status {
  kOk,             ///< A model was found.
  kTooFewPoints,   ///< Fewer points than a minimal set needs.
  kDegenerate,     ///< Points that determine no model (all equal, all collinear); of a search: non-finite ones.
  kNoModel,        ///< Hypotheses were solved, but none was supported by the data.
  kTooManyPoints,  ///< More points than the method can work on: its memory or its indices grow out of proportion.
};

/// "ok", "too_few_points", "degenerate", "no_model" or "too_many_points".
std::string_view ToString(Status status);

/// A mistake of the caller's (argument, option, configuration, file, command line): one clear line for the terminal.
/// Both catch (const diffsac::Error&) and catch (const std::invalid_argument&) take it.
class Error : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// What to tell the user: the whole of an Error, of another exception the first line, for libraries append where in
/// their code it was thrown.
std::string MessageOf(const std::exception& exception);

}  // namespace diffsac
