#include "lab/report/html_page.h"

#include <catch2/catch.hpp>

namespace diffsac {
namespace {

using Catch::Contains;

constexpr const char* kNasty = "</script><script>alert(1)</script>\"'&";

Table SmallTable() {
  Table table;
  table.heading = "accuracy";
  table.columns = {"method", "0.5", "note"};
  table.rows = {{{"RANSAC", "0.51 [0.45, 0.57]", "3 views"}, {false, true, false}, false},
                {{"Theirs", "0.60", ""}, {false, false, false}, true},
                {{"Ours", kUnknown, ""}, {false, false, false}, false}};
  return table;
}

TEST_CASE("whatever a name holds, it is text on the page") {
  HtmlPage page(kNasty);
  page.AddSubtitle(kNasty);
  page.AddSection(kNasty);
  page.AddSection("another");
  page.AddText(kNasty);
  page.AddWarning(kNasty);
  Table table = SmallTable();
  table.heading = table.columns[1] = table.rows[0].cells[0] = table.rows[0].cells[1] = kNasty;
  page.AddTable(table, kNasty);
  page.AddPicture("png", kNasty);
  page.AddJson("list", "[\"</script><script>alert(1)</script>\"]");
  CHECK_THAT(page.Text(), !Contains("<script>alert") && Contains("&lt;/script&gt;&lt;script&gt;alert(1)") &&
                              Contains("[\"\\u003c/script>\\u003cscript>alert(1)"));
}

TEST_CASE("a table has values to sort by, intervals in smaller type, and the paper's rows apart") {
  HtmlPage page("t");
  page.AddTable(SmallTable(), "a note");
  const std::string html = page.Text();
  CHECK_THAT(html,
             Contains("<th scope=\"col\" aria-sort=\"none\" class=\"number\"><button type=\"button\">0.5</button>"));
  CHECK_THAT(html, Contains("class=\"number best\" data-value=\"0.51\">0.51 <small>[0.45, 0.57]</small></td>"));
  CHECK_THAT(html, Contains("<td class=\"number\">–</td>") && Contains("<td>3 views</td>") && Contains("a note"));
  CHECK(html.find("Ours") < html.find("<tbody class=\"paper\">"));
  CHECK(html.find("Theirs") > html.find("<tbody class=\"paper\">"));
}

TEST_CASE("a page loads nothing from elsewhere") {
  HtmlPage page("t");
  page.AddSection("s");
  page.AddTable(SmallTable());
  page.AddBytes("image", "abc");
  page.AddScript("diffsacPage.json('x');");
  CHECK_THAT(page.Text(), !Contains("http:") && !Contains("https:") && !Contains("src=") && !Contains("@import") &&
                              Contains("default-src 'none'") && Contains("id=\"image\">YWJj</script>"));
}

TEST_CASE("base64 is that of RFC 4648") {
  CHECK(Base64("").empty());
  CHECK(Base64("f") == "Zg==");
  CHECK(Base64("fo") == "Zm8=");
  CHECK(Base64("foobar") == "Zm9vYmFy");
  CHECK(Base64(std::string("\xff\xfe\0", 3)) == "//4A");
}

}  // namespace
}  // namespace diffsac
