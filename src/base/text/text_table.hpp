#pragma once

#include <string>
#include <vector>

namespace conddp {

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
