#include "lab/config/option_reference.h"

#include <algorithm>

namespace diffsac {
namespace {

std::string Code(const std::string& text) { return text.empty() ? "" : "`" + text + "`"; }

// A table's cells end at a bar.
std::string Cell(const std::string& text) {
  std::string cell;
  for (const char c : text) cell += c == '|' ? "\\|" : std::string(1, c);
  return cell;
}

std::string Sentence(std::string text) {
  if (text.empty()) return text;
  if (text.front() >= 'a' && text.front() <= 'z') text.front() = static_cast<char>(text.front() - 'a' + 'A');
  if (std::string(".:;").find(text.back()) == std::string::npos) text += ".";
  return text;
}

std::string MeaningOf(const OptionDescription& key) {
  const std::string when = key.when.empty() ? "" : "Only with " + key.when + ".";
  return when + (when.empty() || key.help.empty() ? "" : " ") + Sentence(key.help);
}

std::string Join(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

struct Differences {
  std::vector<std::string> defaults, missing;
};

void Compare(const std::string& path, const std::vector<OptionDescription>& base,
             const std::vector<OptionDescription>& keys, Differences* found) {
  for (const OptionDescription& old : base) {
    const std::string full = Join(path, old.key);
    const auto same = std::find_if(keys.begin(), keys.end(), [&](const auto& key) { return key.key == old.key; });
    if (same == keys.end()) {
      found->missing.push_back(Code(full));
      continue;
    }
    if (same->default_value != old.default_value)
      found->defaults.push_back(Code(full) + ": " + (same->default_value.empty() ? "none" : Code(same->default_value)));
    Compare(full, old.children, same->children, found);
  }
}

// Those of `keys` that `known` has not.
std::vector<OptionDescription> KeysBeside(const std::vector<OptionDescription>& known,
                                          const std::vector<OptionDescription>& keys) {
  std::vector<OptionDescription> more;
  for (const OptionDescription& key : keys)
    if (std::none_of(known.begin(), known.end(), [&](const auto& other) { return other.key == key.key; }))
      more.push_back(key);
  return more;
}

std::string List(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts) list += (list.empty() ? "" : ", ") + text;
  return list;
}

}  // namespace

std::string DifferenceText(const std::vector<OptionDescription>& base, const std::vector<OptionDescription>& keys) {
  Differences found;
  Compare("", base, keys, &found);
  std::string text = found.defaults.empty() ? "" : "with the defaults " + List(found.defaults);
  if (!found.missing.empty()) text += (text.empty() ? "without " : "; without ") + List(found.missing);
  return text;
}

void OptionReference::AddText(int level, const std::string& heading, const std::string& text) {
  text_ += (text_.empty() ? "" : "\n") + std::string(static_cast<std::size_t>(level), '#') + " " + heading + "\n";
  if (!text.empty()) text_ += "\n" + text + "\n";
}

// Behind a K, large or small.
std::string OptionReference::PointerTo(const Known& known, const std::vector<OptionDescription>& keys) {
  const std::string differ = DifferenceText(known.keys, keys);
  return "eys as of " + known.place + (differ.empty() ? "" : ", " + differ) + ".\n";
}

void OptionReference::AddOptions(const std::string& heading, const std::string& text, const std::string& of,
                                 std::type_index options, const std::vector<OptionDescription>& keys) {
  AddText(3, heading, text);
  if (const Known* known = Find(options)) {
    text_ += "\nK" + PointerTo(*known, keys);
    const std::vector<OptionDescription> more = KeysBeside(known->keys, keys);
    if (more.empty()) return;
    text_ += "Beside them:\n";
    AddKeys("", of, more);
    return;
  }
  if (options != typeid(void)) known_.push_back({options, heading, keys});
  AddKeys("", of, keys);
}

void OptionReference::AddKeys(const std::string& path, const std::string& of,
                              const std::vector<OptionDescription>& keys) {
  if (keys.empty()) {
    text_ += "\nNo keys.\n";
    return;
  }
  text_ += "\n| key | default | value | meaning |\n|---|---|---|---|\n";
  for (const OptionDescription& key : keys)
    text_ += "| " + Code(key.key) + " | " + Cell(Code(key.default_value)) + " | " + Cell(key.type) + " | " +
             Cell(MeaningOf(key)) + " |\n";
  for (const OptionDescription& key : keys) {
    if (key.children.empty()) continue;
    const std::string full = Join(path, key.key);
    if (const Known* known = Find(key.options)) {
      text_ += "\n" + Code(full) + ": k" + PointerTo(*known, key.children);
      continue;
    }
    AddText(3, Code(full) + of, Sentence(key.help));
    if (key.options != typeid(void)) known_.push_back({key.options, Code(full) + of, key.children});
    AddKeys(full, of, key.children);
  }
}

const OptionReference::Known* OptionReference::Find(std::type_index options) const {
  if (options == typeid(void)) return nullptr;
  const auto found =
      std::find_if(known_.begin(), known_.end(), [&](const Known& known) { return known.options == options; });
  return found == known_.end() ? nullptr : &*found;
}

}  // namespace diffsac
