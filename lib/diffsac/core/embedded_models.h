#pragma once

#include <string>
#include <string_view>

namespace diffsac {

// The networks that the functions of diffsac.h use are compiled into the library, so that no call needs a file.

/// What the place of a network in the library begins with, where other networks have a path:
/// "embedded:essential/model.safetensors".
inline constexpr std::string_view kEmbedded = "embedded:";

/// The place of a network of models/ ("essential/model.safetensors"): its path in `folder`, or, if that is empty, in
/// the library.
std::string ModelPlace(const std::string& name, const std::string& folder = "");

/// The bytes of the network at a place in the library, those of its file in models/. Empty if the library has none
/// there, as for a path.
std::string_view EmbeddedModel(std::string_view place);

}  // namespace diffsac
