#include "base/text/csv_line.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(CsvLine, CellsAreWithoutTheSpacesAroundThemAndKnowWhereTheirTextBegins) {
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

}  // namespace
}  // namespace conddp
