#pragma once

#include <string>

namespace diffsac {

/// Draws `folder/name.png` with gnuplot. The script, with its data in it, stays beside the picture as `name.gp`, so
/// that `gnuplot name.gp` draws it again. Terminal, fonts and output are set here; `script` draws. `width` and `height`
/// are in pixels. False, with a warning in the log, when gnuplot is missing or fails; throws Error when script or
/// picture cannot be written.
bool DrawPicture(const std::string& folder, const std::string& name, const std::string& script, int width, int height);

/// Whether gnuplot can be started.
bool HasGnuplot();

/// Text in double quotes for a script, free of enhanced-text markup.
std::string GnuplotText(const std::string& text);

/// A number that gnuplot reads ("NaN" is a missing point).
std::string GnuplotNumber(double value);

}  // namespace diffsac
