#include "robot/urdf/xml_outline.hpp"

#include <gtest/gtest.h>

#include "base/text/spelling.hpp"

namespace conddp {
namespace {

TEST(XmlOutline, KeepsElementsParentsAndPlaces) {
  const XmlOutline outline = scan_xml(
      "\xEF\xBB\xBF<?xml version=\"1.0\"?>\n<!-- <no> -->\n"
      "<a x = '1'\n y=\"\xC3\xA9>\"><b/> text <!-- c --> <b></b><![CDATA[<d>]]>\n</a>\n<!-- -->");
  ASSERT_FALSE(outline.defect) << outline.defect->message;
  ASSERT_EQ(outline.elements.size(), 3u);
  const XmlElement& a = outline.elements[0];
  EXPECT_EQ(a.tag, "a");
  EXPECT_EQ(a.line, 3);
  EXPECT_EQ(a.column, 1);
  EXPECT_EQ(a.attribute("x"), "1");
  EXPECT_EQ(a.attribute("y"), "\xC3\xA9>");
  EXPECT_FALSE(a.attribute("z"));
  EXPECT_EQ(a.end_tag, "</a>");
  EXPECT_EQ(outline.children(0, "b"), (std::vector<int>{1, 2}));
  EXPECT_EQ(outline.elements[1].line, 4);
  EXPECT_EQ(outline.elements[1].column, 9);  // é counts as one character
  EXPECT_EQ(outline.elements[1].end_tag, "");
  EXPECT_EQ(outline.elements[2].end_tag, "</b>");
}

TEST(XmlOutline, TruncationAtAnyByteIsOnlyAnError) {
  const std::string whole = "<?xml?><a b=\"c\"><!-- d --><e f='g'/><![CDATA[h]]></a>";
  ASSERT_FALSE(scan_xml(whole).defect);
  for (std::size_t size = 1; size < whole.size(); ++size) {
    const XmlOutline outline = scan_xml(std::string_view(whole).substr(0, size));
    EXPECT_TRUE(outline.defect || outline.elements.empty()) << size;
  }
}

TEST(XmlOutline, RejectsTooManyAttributes) {
  std::string text = "<a";
  for (int i = 0; i < 100'000; ++i) text += " b" + std::to_string(i) + "=\"\"";
  const XmlOutline outline = scan_xml(text + "/>");
  ASSERT_TRUE(outline.defect);
  EXPECT_NE(outline.defect->message.find("more than 64 attributes"), std::string::npos);
}

TEST(NearNames, CountEditsAndSwaps) {
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(edit_distance("parent", "paretn"), 1);
  EXPECT_EQ(edit_distance("LF_HAA", "lf_haa"), 0);
}

TEST(NearNames, AreTheNearestOnesOrAllThereAre) {
  const std::vector<std::string> legs{"LF_HAA", "LF_HFE", "RF_HAA", "tail"};
  EXPECT_EQ(similar_names("LF_HA", legs).front(), "LF_HAA");
  EXPECT_TRUE(similar_names("wing_tip", legs).empty());
  EXPECT_EQ(name_hint("tial", legs, "joints"), "did you mean 'tail'?");
  EXPECT_EQ(name_hint("wing_tip", legs, "joints"), "joints: LF_HAA, LF_HFE, RF_HAA, tail");
  EXPECT_EQ(name_hint("a", {}, "joints"), "there are no joints");
}

}  // namespace
}  // namespace conddp
