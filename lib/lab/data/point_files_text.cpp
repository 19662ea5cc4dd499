#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/data/finite_points.h"
#include "lab/data/point_files.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"

namespace diffsac {
namespace {

constexpr std::string_view kSeparators = " \t,;", kBlanks = " \t\"'";

using Cells = std::vector<std::string>;

std::string Trimmed(std::string_view text) {
  const std::size_t start = std::min(text.find_first_not_of(kBlanks), text.size());
  return std::string(text.substr(start, text.find_last_not_of(kBlanks) + 1 - start));
}

std::string_view WithoutComment(std::string_view line) { return line.substr(0, std::min(line.find('#'), line.size())); }

/// What a header's values are separated by; ' ' stands for any of the separators.
char SeparatorOf(std::string_view header) {
  for (const char separator : {';', ',', '\t'})
    if (header.find(separator) != std::string_view::npos) return separator;
  return ' ';
}

Cells CellsOf(std::string_view line, char separator) {
  Cells cells;
  std::size_t at = 0;
  if (separator == ' ')
    for (const std::string_view word : SplitWords(line, kSeparators)) cells.emplace_back(Trimmed(word));
  else
    for (const std::string& cell : TakeCsvLine(std::string(line), &at, separator)) cells.push_back(Trimmed(cell));
  return cells;
}

/// Without its unit, in small letters: "X [m]" is "x".
std::string NameOf(std::string_view cell) {
  std::string name = Trimmed(cell.substr(0, std::min(cell.find_first_of("[({#", 1), cell.size())));
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// Whether a column of this name counts the rows; pandas gives it no name.
bool IsIndexName(const std::string& name) {
  for (const char* index : {"", "#", "id", "idx", "index", "row", "no", "no.", "nr", "nr.", "fid", "oid", "objectid"})
    if (name == index) return true;
  return name.ends_with("_id") || name.ends_with(" id") || name.starts_with("unnamed");
}

std::string Listed(const Cells& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "'" : ", '") + name + "'";
  return text;
}

bool IsNumber(std::string_view word) {
  double value = 0.0;
  return ParseNumber(word, &value);
}

// The rows read so far; knows the place for messages.
class TextReader {
 public:
  TextReader(const std::string& path, const TextColumns& asked) : path_(path), asked_(asked) {}

  void ReadLine(std::string_view line) {
    ++line_;
    const std::size_t start = line.find_first_not_of(" \t");
    if (start == std::string_view::npos) return;
    const bool comment = line[start] == '#';
    if (!seen_content_ && comment) comment_ = line.substr(start);
    if (comment) return;
    const bool first = !std::exchange(seen_content_, true);
    if (first && TakeHeader(line)) return;
    if (first && !comment_.empty()) TakeCommentedHeader(CellsOf(WithoutComment(line), ' ').size());
    if (columns_ == 0 && !names_.empty()) Choose(line);
    ReadRow(line);
  }

  TextTable Table() const {
    if (columns_ == 0)
      throw Error(path_ + ": no " + asked_.what + " in this file; expected " + CountsText() + " numbers a line");
    TextTable table;
    const auto width = chosen_.empty() ? columns_ : chosen_.size();
    const auto rows = static_cast<Eigen::Index>(values_.size() / width);
    table.values = Eigen::Map<const PointMatrix>(values_.data(), rows, static_cast<Eigen::Index>(width));
    table.names = All();
    if (by_name_)
      std::erase_if(table.names, [&](const std::string& name) { return Find(name) < 0; });
    else
      table.names.resize(width);
    table.header = Listed(names_);
    return table;
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const {
    throw Error(path_ + ":" + std::to_string(line_) + ": " + message);
  }

  /// The names of columns in their order, the needed ones first.
  Cells All() const {
    Cells names = asked_.needed;
    names.insert(names.end(), asked_.optional.begin(), asked_.optional.end());
    return names;
  }

  bool HasNeeded() const {
    return std::all_of(asked_.needed.begin(), asked_.needed.end(),
                       [&](const std::string& name) { return Find(name) >= 0; });
  }

  bool IsWidth(std::size_t count) const { return count >= asked_.needed.size() && count <= All().size(); }

  /// "2 or 3", "4 to 7".
  std::string CountsText() const {
    const std::size_t least = asked_.needed.size(), most = All().size();
    return std::to_string(least) + (most == least + 1 ? " or " : " to ") + std::to_string(most);
  }

  /// Whether the first line is a header: without a number, or without a name for the first column, as pandas has it.
  bool TakeHeader(std::string_view line) {
    const auto words = SplitWords(WithoutComment(line), kSeparators);
    const char separator = SeparatorOf(line);
    const Cells cells = CellsOf(line, separator);
    const bool unnamed = separator != ' ' && cells[0].empty(),
               numbers = std::any_of(words.begin(), words.end(), IsNumber);
    // "Unnamed: 0" is a name with a number in it.
    const bool named = std::none_of(cells.begin(), cells.end(), IsNumber) &&
                       std::any_of(line.begin(), line.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
    if (numbers && !named && !unnamed) return false;
    if (line.starts_with("//")) line.remove_prefix(2);
    SetHeader(line);
    return true;
  }

  /// "# x y z" as NumPy writes it, or "#,x,y,z", whose first column has this name: where it fits the first row.
  void TakeCommentedHeader(std::size_t columns) {
    for (const std::size_t skipped : {1, 0}) {
      SetHeader(std::string_view(comment_).substr(skipped));
      if (names_.size() == columns && HasNeeded()) return;
    }
    names_.clear();
  }

  void SetHeader(std::string_view line) {
    separator_ = SeparatorOf(line);
    names_ = CellsOf(separator_ == ' ' ? line.substr(0, line.find('#', 1)) : line, separator_);
    // Units of their own words: "x [m] y [m]".
    if (separator_ == ' ')
      std::erase_if(names_, [](const std::string& name) { return name[0] == '[' || name[0] == '('; });
    while (names_.size() > 1 && names_.back().empty()) names_.pop_back();
  }

  int Find(const std::string& name) const {
    int found = -1;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (NameOf(names_[i]) != name) continue;
      if (found >= 0) throw Error(path_ + ": two columns are named " + name + ": " + Listed(names_));
      found = static_cast<int>(i);
    }
    return found;
  }

  /// The columns that are coordinates, by their names, or by their places with a word about it.
  void Choose(std::string_view line) {
    by_name_ = HasNeeded();
    const std::size_t count = Split(line, names_.size()).size();
    // R gives the column of row names, in quotes or counted, no name.
    const auto words = SplitWords(line, kSeparators);
    const std::string_view first = words.empty() ? "x" : words[0];
    const bool named_row = first.starts_with('"') || first.find_first_not_of("0123456789") == std::string_view::npos;
    const std::size_t shift = count == names_.size() + 1 && separator_ != ',' && named_row ? 1 : 0;
    if (by_name_) {
      for (const std::string& name : All())
        if (const int column = Find(name); column >= 0) chosen_.push_back(static_cast<std::size_t>(column) + shift);
    } else if (count == names_.size()) {
      for (std::size_t i = 0; i < names_.size(); ++i)
        if (!IsIndexName(NameOf(names_[i]))) chosen_.push_back(i);
      if (!IsWidth(chosen_.size())) chosen_.clear();
    }
    if (!chosen_.empty()) columns_ = names_.size() + shift;
    if (by_name_) {
      SayUnread();
      return;
    }
    Cells taken;
    for (const std::size_t column : chosen_) taken.push_back(names_[column - shift]);
    std::string expected;
    for (const std::string& name : asked_.needed)
      expected += (expected.empty() ? "" : name == asked_.needed.back() ? " and " : ", ") + name;
    WarnOnce(path_ + ": its header names no columns " + expected + ": " +
             (taken.empty() ? "all are" : Listed(taken) + " are") + " taken in their order");
  }

  /// Columns under other names than those that are read, where one of these is missing and may be meant.
  void SayUnread() const {
    const Cells all = All();
    Cells unread, missing;
    std::copy_if(all.begin(), all.end(), std::back_inserter(missing), [&](const auto& name) { return Find(name) < 0; });
    std::copy_if(names_.begin(), names_.end(), std::back_inserter(unread), [&](const std::string& name) {
      return !IsIndexName(NameOf(name)) && std::find(all.begin(), all.end(), NameOf(name)) == all.end();
    });
    if (!unread.empty() && !missing.empty())
      WarnOnce(path_ + ": columns that are not read: " + Listed(unread) + "; names that would be: " + Listed(missing));
  }

  /// A row's values: by the header's separator, or another one where that gives as many as the header has names.
  Cells Split(std::string_view line, std::size_t count) const {
    Cells cells = CellsOf(line, separator_);
    while (cells.size() > count && cells.back().empty()) cells.pop_back();
    if (cells.size() == count) return cells;
    const std::string_view plain = WithoutComment(line);
    for (const char separator : {separator_, ' '})
      if (Cells other = CellsOf(plain, separator); other.size() == count) return other;
    return cells;
  }

  void ReadRow(std::string_view line) {
    const Cells cells = chosen_.empty() ? CellsOf(WithoutComment(line), ' ') : Split(line, columns_);
    CheckColumns(cells.size());
    const bool both = line.find(';') != std::string_view::npos && line.find(',') != std::string_view::npos;
    if (chosen_.empty() && both) Fail("commas and semicolons in one line: expected numbers with a point, not a comma");
    for (const std::size_t column : chosen_) values_.push_back(Value(cells[column]));
    if (chosen_.empty())
      for (const std::string& cell : cells) values_.push_back(Value(cell));
  }

  double Value(const std::string& cell) const {
    double value = 0.0;
    if (ParseNumber(cell, &value) || ParseNumber(Trimmed(WithoutComment(cell)), &value)) return value;
    // As pandas and R write a value that is missing.
    if (cell.empty() || cell == "NA") return std::nan("");
    const bool comma = cell.find(',') != std::string::npos;
    Fail("expected a number, found '" + cell + "'" + (comma ? ": with a point, not a comma" : ""));
  }

  void CheckColumns(std::size_t count) {
    if (columns_ == 0 && !IsWidth(count)) Fail("expected " + CountsText() + " columns, found " + std::to_string(count));
    if (columns_ == 0) columns_ = count;
    if (columns_ != count)
      Fail("expected " + std::to_string(columns_) +
           (chosen_.empty() ? " columns as in the lines before" : " columns as the header has") + ", found " +
           std::to_string(count));
  }

  std::string path_, comment_;
  const TextColumns& asked_;
  int line_ = 0;
  bool seen_content_ = false;
  char separator_ = ' ';
  Cells names_;                      // of the header; none: empty
  std::vector<std::size_t> chosen_;  // columns that are read; empty: all
  bool by_name_ = false;             // these are those that the header names so
  std::size_t columns_ = 0;
  std::vector<double> values_;
};

}  // namespace

TextTable ReadTextTable(const std::string& path, const TextColumns& columns) {
  const std::string content = ReadTextFile(path);
  std::string_view rest = content, line;
  TextReader reader(path, columns);
  while (TakeLine(&rest, &line)) reader.ReadLine(line);
  return reader.Table();
}

PointSet ReadTextPoints(const std::string& path) {
  const TextTable table = ReadTextTable(path, {"points", {"x", "y"}, {"z"}});
  const std::filesystem::path file(path);
  PointSet set;
  set.name = file.filename().string();
  set.scene = std::filesystem::absolute(file).parent_path().filename().string();
  set.points = table.values;
  set.columns = table.header;
  return set;
}

}  // namespace diffsac
