#pragma once

namespace diffsac {

/// How the programs end (docs/reliability.md): done; photographs without a model; bad input, data or files, which one
/// line on stderr names; stopped by Ctrl-C or SIGTERM.
inline constexpr int kExitOk = 0;
inline constexpr int kExitNoModel = 1;
inline constexpr int kExitBadInput = 2;
inline constexpr int kExitInterrupted = 130;

/// The same, for --help, and where its documentation is.
inline constexpr const char* kExitCodesHelp =
    "In an installation these pages are in share/doc/diffsac, configurations in share/diffsac/configs.\n"
    "Exit status: 0 done; 2 bad input, data or files, named in one line on stderr; 130 stopped by Ctrl-C or SIGTERM.";

}  // namespace diffsac
