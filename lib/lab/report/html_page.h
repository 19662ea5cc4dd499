#pragma once

#include <string>
#include <string_view>

#include "lab/report/report.h"

namespace diffsac {

/// Text as it stands in HTML and in quoted attributes: no markup of its own.
std::string HtmlText(std::string_view text);

/// Bytes as base64 (RFC 4648), padded.
std::string Base64(std::string_view bytes);

/// A page that needs nothing beside itself: style, scripts, pictures and data are in it, and it asks the browser to
/// load nothing else. What is called text may be anything: it is escaped. What is called markup or script is the
/// caller's own and stands as it is. Parts appear in the order in which they are added.
///
/// Tables can be sorted by a click on a column's name. The page's address may ask for it: `#sort=2.3` is a click on
/// column 3 of table 2, both counted from 1 (`#sort=2.3.asc`: ascending).
class HtmlPage {
 public:
  explicit HtmlPage(std::string title);

  /// Asks the browser to load the page again after so many seconds.
  void AddReload(int seconds);
  /// A line under the title.
  void AddSubtitle(const std::string& text);
  /// A heading, which the page's list of sections names.
  void AddSection(const std::string& heading);
  /// A paragraph.
  void AddText(const std::string& text);
  /// A paragraph that must not be overlooked.
  void AddWarning(const std::string& text);
  /// A table under its heading. Numbers are right-aligned; "0.51 [0.45, 0.57]" shows its interval in smaller type; rows
  /// of the paper stay below the others however the table is sorted. `note` stands below it.
  void AddTable(const Table& table, const std::string& note = "");
  /// A picture, the bytes of a PNG file, with a caption below it.
  void AddPicture(std::string_view png, const std::string& caption);
  void AddMarkup(const std::string& html);
  /// JSON that scripts find by `id` (letters, digits, dashes), parsed when they ask for it.
  void AddJson(const std::string& id, const std::string& json);
  /// Bytes that scripts find by `id`, as base64.
  void AddBytes(const std::string& id, std::string_view bytes);
  /// Runs once the page is there. `diffsacPage` (scripts/report/page.js) is at its service.
  void AddScript(std::string_view script);

  /// The whole page.
  std::string Text() const;

 private:
  std::string title_, subtitles_, sections_, body_, data_, scripts_;
  int section_count_ = 0, reload_seconds_ = 0;
};

}  // namespace diffsac
