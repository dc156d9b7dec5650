#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace conddp {

enum class Severity { kError, kWarning, kNote };

/// An error, warning or note about an input, with its place. Positions are 1-based and in
/// characters; line 0 means the whole file.
struct Diagnostic {
  std::string file;
  int line = 0;
  int column = 0;
  std::string path;  ///< key path in `--set` syntax ("costs.effort.weight"); empty outside YAML
  Severity severity = Severity::kError;
  std::string message;
  std::string hint;                   ///< suggested remedy; may be empty
  std::vector<std::string> accepted;  ///< names accepted at this place, if there are few
  int source = -1;  ///< index of a text in Diagnostics; several texts may have the same name
};

/// A position in a text of Diagnostics.
struct Mark {
  int source = -1;  ///< index into Diagnostics' texts, −1 without a text
  int line = 0;
  int column = 0;
};

/// A place in an input, with its key path.
struct Place {
  Mark mark;
  std::string path;
};

/// A value and the place where it was written.
template <class T>
struct Located {
  T value{};
  Place place;
};
using Name = Located<std::string>;

/// An input file.
struct InputFile {
  std::string file;
  std::string sha256;  ///< of its bytes
};

/// Collects diagnostics, the texts that they refer to, and the data files that were read.
class Diagnostics {
 public:
  /// Errors beyond this limit are counted but not stored.
  static constexpr int kMaxErrors = 100;

  /// Adds a text; returns its index for Mark::source.
  int add_source(std::string name, std::string text);
  const std::string& source_name(int source) const { return sources_[source]->name; }
  /// A line of a text (from 1), without its line end.
  std::string_view line(int source, int number) const { return sources_[source]->line(number); }
  /// Converts a byte offset in a line (0-based, as in yaml-cpp) into a 1-based character position.
  int character_column(int source, int line, int byte) const;

  void error(const Place& place, std::string message, std::string hint = {},
             std::vector<std::string> accepted = {});
  void warning(const Place& place, std::string message, std::string hint = {});
  void note(const Place& place, std::string message, std::string hint = {});
  void add(Diagnostic diagnostic);

  const std::vector<Diagnostic>& list() const { return list_; }
  bool has_errors() const { return errors_ > 0; }
  int error_count() const { return errors_; }
  /// Records a data file, only once.
  void add_data_file(InputFile file);
  const std::vector<InputFile>& data_files() const { return data_files_; }
  /// The line that a diagnostic refers to, from a text or a file; empty if unavailable.
  std::string source_line(const Diagnostic& diagnostic) const;

 private:
  struct Source {
    std::string name;
    std::string text;
    std::vector<std::size_t> line_starts;
    std::string_view line(int number) const;
  };
  Diagnostic at(const Place& place, Severity severity, std::string message, std::string hint) const;

  std::vector<std::shared_ptr<const Source>> sources_;  ///< copies share the texts
  std::vector<Diagnostic> list_;
  std::vector<InputFile> data_files_;
  int errors_ = 0;
};

std::string_view severity_name(Severity severity);

/// Formats diagnostics in compiler style: `file:line:column: error: message`, the source line, a
/// caret, and a hint. Omits diagnostics less severe than `least`; counts errors beyond `limit`
/// without showing them. Lines have at most `width` characters, unless it is 0.
std::string format_diagnostics(const Diagnostics& diagnostics, bool colour,
                               Severity least = Severity::kNote, int limit = 20, int width = 0);

}  // namespace conddp
