#include "base/text/csv_line.hpp"

#include <string>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(CsvLine, TrimsCellsAndRecordsWhereTextBegins) {
  const auto cells = split_csv_line(" a,\tb c \r");
  ASSERT_EQ(cells.size(), 2u);
  EXPECT_EQ(cells[0].text, "a");
  EXPECT_EQ(cells[0].byte, 1);
  EXPECT_EQ(cells[1].text, "b c");
  EXPECT_EQ(cells[1].byte, 4);
}

TEST(CsvLine, EmptyCellsCountAndBeginBehindTheirComma) {
  const auto cells = split_csv_line("1,  ,");
  ASSERT_EQ(cells.size(), 3u);
  EXPECT_EQ(cells[1].text, "");
  EXPECT_EQ(cells[1].byte, 2);
  EXPECT_EQ(cells[2].byte, 5);
  EXPECT_EQ(split_csv_line("").size(), 1u);
}

std::vector<std::string> texts(std::string_view line) {
  std::vector<std::string> texts;
  for (const CsvCell& cell : split_csv_line(line)) texts.push_back(cell.text);
  return texts;
}

using Texts = std::vector<std::string>;

TEST(CsvLine, QuotedTextMayContainCommasSpacesAndQuotes) {
  EXPECT_EQ(texts(R"(1,"[0.3, 0.4]" , "say ""no"", twice","",x)"),
            (Texts{"1", "[0.3, 0.4]", "say \"no\", twice", "", "x"}));
  EXPECT_EQ(texts("\" a \"\r"), Texts{" a "});
  EXPECT_EQ(split_csv_line(R"(1, "a,b",c)")[1].byte, 3);
  EXPECT_EQ(split_csv_line(R"(1, "a,b",c)")[2].byte, 9);
}

TEST(CsvLine, RecognizesSpreadsheetFormulas) {
  for (const char* text : {"=1+1", "@SUM(A1)", "-x", "+x"})
    EXPECT_TRUE(begins_formula(text)) << text;
  for (const char* text : {"", "x=1", "_=1", "1-2"}) EXPECT_FALSE(begins_formula(text)) << text;
}

TEST(CsvLine, QuotesInsideACellArePartOfIt) {
  EXPECT_EQ(texts(R"(3" pipe,"open, b)"), (Texts{"3\" pipe", "\"open", "b"}));
  EXPECT_EQ(texts(R"("a" b,"c")"), (Texts{"\"a\" b", "c"}));
  EXPECT_EQ(texts("\"\"\""), Texts{"\"\"\""});
}

}  // namespace
}  // namespace conddp
