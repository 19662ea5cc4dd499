#pragma once

#include <string>
#include <typeindex>
#include <utility>
#include <vector>

#include "lab/options/options.h"

namespace diffsac {

/// Describes options in Markdown: a section with a table for each map of keys. A struct that stands in several places
/// is described where it is first met; elsewhere the text points there and names the defaults that differ.
class OptionReference {
 public:
  /// A heading with text below it. level: of the heading, from 2.
  void AddText(int level, const std::string& heading, const std::string& text);

  /// The keys of one map, and of the maps within it, each in a section of its own: "`key`" + of (" of `method:
  /// clnet`"). options: the struct that was described.
  void AddOptions(const std::string& heading, const std::string& text, const std::string& of, std::type_index options,
                  const std::vector<OptionDescription>& keys);

  const std::string& text() const { return text_; }

 private:
  struct Known {
    std::type_index options;
    std::string place;  ///< Where it is described.
    std::vector<OptionDescription> keys;
  };
  const Known* Find(std::type_index options) const;
  static std::string PointerTo(const Known& known, const std::vector<OptionDescription>& keys);
  void AddKeys(const std::string& path, const std::string& of, const std::vector<OptionDescription>& keys);

  std::string text_;
  std::vector<Known> known_;
};

/// "with the defaults `a.b`: `1`, `c`: `x`; without `d`": how `keys` differ from `base`, an empty text when they don't.
std::string DifferenceText(const std::vector<OptionDescription>& base, const std::vector<OptionDescription>& keys);

}  // namespace diffsac
