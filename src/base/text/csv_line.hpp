#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// A cell of a line of a CSV file.
struct CsvCell {
  std::string text;  ///< without spaces and quotes around it
  int byte;          ///< where it begins in the line, with its quotes; an empty one: the cell
};

/// The cells of a line, whose end is not part of it. Quotes are those of RFC 4180: between them
/// commas and spaces are part of the text, and two quotes are one. A quote that does not begin a
/// cell, or is not closed before its end, is part of the text.
std::vector<CsvCell> split_csv_line(std::string_view line);

/// Without spaces, tabs and a carriage return around it.
std::string_view trimmed_csv(std::string_view text);

/// Whether spreadsheets take a cell that begins like this text for a formula and compute it.
bool begins_formula(std::string_view text);

}  // namespace conddp
