#include "robot/urdf/load_xml.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

/// "offset: message" of the first defect; empty without one.
std::string defect_of(const std::string& text) {
  pugi::xml_document document;
  const auto defect = load_xml(text, document);
  return defect ? std::to_string(defect->offset) + ": " + defect->message : "";
}

TEST(LoadXml, KeepsElementsAndTextAsWritten) {
  const std::string text =
      "\xEF\xBB\xBF<?xml version=\"1.0\"?>\n<!DOCTYPE a>\n<!-- <no> -->\n"
      "<a x = '1'\n y=\"&lt;\xC3\xA9>\"><b/> text <!-- c --> <![CDATA[<d>]]>\n</a>\n<!-- -->";
  pugi::xml_document document;
  const auto defect = load_xml(text, document);
  ASSERT_FALSE(defect) << defect->message;
  const pugi::xml_node a = document.document_element();
  EXPECT_STREQ(a.name(), "a");
  EXPECT_STREQ(a.attribute("x").value(), "1");
  EXPECT_STREQ(a.attribute("y").value(), "&lt;\xC3\xA9>");
  EXPECT_EQ(a.child("b").offset_debug(), static_cast<std::ptrdiff_t>(text.find("b/>")));
  EXPECT_FALSE(a.child("d"));
}

TEST(LoadXml, DefectsHaveMessagesAndPlaces) {
  EXPECT_EQ(defect_of("<!-- -->"), "0: the file has no XML element");
  EXPECT_EQ(defect_of("\n hello"), "2: text outside the document's root element");
  EXPECT_EQ(defect_of("<![CDATA[x]]><a/>"), "9: text outside the document's root element");
  EXPECT_EQ(defect_of("<a><b></b>"), "0: <a> is never closed");
  EXPECT_EQ(defect_of("<a>\n<b>\n"), "4: <b> is never closed");
  EXPECT_EQ(defect_of("<a>\n<bc></b></a>"), "8: </b> where <bc> of line 2 is open");
  EXPECT_EQ(defect_of("<a></a></b>"), "7: </b> closes nothing");
  EXPECT_EQ(defect_of("<a></a"), "3: an end tag lacks its '>'");
  EXPECT_EQ(defect_of("<a/>\n<b/>"), "5: a second root element <b>");
  EXPECT_EQ(defect_of("<a b=c/>"), "5: the value of b in <a> is not quoted");
  EXPECT_EQ(defect_of("<a b='c"), "6: the value of b in <a> is not closed, or no blank follows");
  EXPECT_EQ(defect_of("<a b='1'c='2'/>"),
            "8: the value of b in <a> is not closed, or no blank follows");
  EXPECT_EQ(defect_of("<a b='c><d e='1'/></a>"), "3: the value of b in <a> is never closed");
  EXPECT_EQ(defect_of("<a b='1' b='2'/>"), "9: attribute b in <a> is given twice");
  EXPECT_EQ(defect_of("<a ,/>"), "3: an attribute is expected in <a>");
  EXPECT_EQ(defect_of("<a>< b/></a>"), "3: '<' without an element's name");
  EXPECT_EQ(defect_of("<a><!-- b</a>"), "3: a comment is never closed");
  EXPECT_EQ(defect_of("<?xml"), "0: a processing instruction is never closed");
  EXPECT_EQ(defect_of("<a><![CDATA[b</a>"), "3: CDATA is never closed");
  const std::string own = "a document type declaration of its own is not accepted here";
  EXPECT_EQ(defect_of("<!DOCTYPE  a [<!ENTITY b 'c'>]><a/>"), "0: " + own);
  EXPECT_EQ(defect_of("<a><!DOCTYPE b></a>"), "3: " + own);
}

TEST(LoadXml, TheFirstDefectCounts) {
  EXPECT_EQ(defect_of("<a b='1' b='2'><c></d>"), "9: attribute b in <a> is given twice");
  EXPECT_EQ(defect_of("<a><c></d></a><e/>"), "6: </d> where <c> of line 1 is open");
}

TEST(LoadXml, TruncationAtAnyByteIsOnlyAnError) {
  const std::string whole = "<?xml?><a b=\"c\"><!-- d --><e f='g'/><![CDATA[h]]></a>";
  ASSERT_EQ(defect_of(whole), "");
  for (std::size_t size = 1; size < whole.size(); ++size)
    EXPECT_NE(defect_of(whole.substr(0, size)), "") << size;
}

TEST(LoadXml, LimitsTheDepth) {
  std::string nested, ends;
  for (int i = 0; i < 64; ++i) {
    nested += "<a>";
    ends += "</a>";
  }
  EXPECT_EQ(defect_of(nested + ends), "");
  EXPECT_EQ(defect_of(nested + "<a>"), "192: elements are nested deeper than 64");
}

TEST(LoadXml, FindsRepetitionsAmongManyAttributes) {
  std::string text = "<a";
  for (int i = 0; i < 100'000; ++i) text += " b" + std::to_string(i) + "=\"\"";
  EXPECT_EQ(defect_of(text + "/>"), "");
  EXPECT_NE(defect_of(text + " b7=\"\"/>").find("attribute b7 in <a> is given twice"),
            std::string::npos);
}

}  // namespace
}  // namespace conddp
