#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// A cell in a line of a CSV file.
struct CsvCell {
  std::string text;  ///< without surrounding spaces and quotes
  int byte;          ///< offset in the line, including quotes; for an empty text, that of the cell
};

/// The cells of a line, given without its line end. Quotes follow RFC 4180: between them commas and
/// spaces are part of the text, and two quotes mean one. A quote is part of the text if it does not
/// begin a cell or is not closed before the cell ends.
std::vector<CsvCell> split_csv_line(std::string_view line);

/// The text without surrounding spaces, tabs and a carriage return.
std::string_view trimmed_csv(std::string_view text);

/// True if spreadsheets evaluate a cell that begins with this text as a formula.
bool begins_formula(std::string_view text);

}  // namespace conddp
