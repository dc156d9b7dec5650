#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// Display width of UTF-8 text on a terminal: its characters, without color escape sequences.
int shown_width(std::string_view text);

/// Text wrapped at spaces into lines of at most `width` characters; 0 means no wrapping. A longer
/// word has its own line. The first line is indented by `first` spaces and the others by `indent`;
/// each has a line end. Line ends in the text are preserved.
std::string wrap_text(std::string_view text, int width, int first, int indent);

/// A table of texts for display, as plain text or as Markdown.
struct TextTable {
  struct Column {
    std::string title;
    bool right = true;  ///< right-aligned, for numbers
  };
  std::vector<Column> columns;
  std::vector<std::vector<std::string>> rows;

  /// The table with aligned columns, two spaces apart, indented by `indent` spaces. Columns that
  /// are empty in every row are omitted.
  std::string text(int indent = 0) const;
  /// The same as a Markdown table.
  std::string markdown() const;

 private:
  bool used(std::size_t column) const;
};

}  // namespace conddp
