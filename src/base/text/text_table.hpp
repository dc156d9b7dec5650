#pragma once

#include <string>
#include <vector>

namespace conddp {

/// A table of texts for people, as plain text or as Markdown.
struct TextTable {
  struct Column {
    std::string title;
    bool right = true;  ///< numbers stand at the right
  };
  std::vector<Column> columns;
  std::vector<std::vector<std::string>> rows;

  /// In columns of their widths, two spaces apart, `indent` spaces before; columns that are empty
  /// in every row are left out.
  std::string text(int indent = 0) const;
  /// The same as a Markdown table.
  std::string markdown() const;

 private:
  bool used(std::size_t column) const;
};

}  // namespace conddp
