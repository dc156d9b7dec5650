#pragma once

#include <string_view>
#include <vector>

namespace conddp {

/// A cell of a line of a CSV file.
struct CsvCell {
  std::string_view text;  ///< without spaces around it
  int byte;               ///< where its text begins in the line; of an empty cell the cell
};

/// The cells of a line, whose end is not part of it: one more than there are commas. Quotes mean
/// nothing.
std::vector<CsvCell> split_csv_line(std::string_view line);

/// Without spaces, tabs and a carriage return around it.
std::string_view trimmed_csv(std::string_view text);

}  // namespace conddp
