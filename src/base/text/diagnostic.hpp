#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace conddp {

enum class Severity { kError, kWarning, kNote };

/// What is wrong, or worth knowing, about an input, with its place. Positions are 1-based and in
/// characters; line 0 means the file as a whole.
struct Diagnostic {
  std::string file;
  int line = 0;
  int column = 0;
  std::string path;  ///< key path as `--set` takes it ("costs.effort.weight"), empty outside YAML
  Severity severity = Severity::kError;
  std::string message;
  std::string hint;                   ///< what to do about it, may be empty
  std::vector<std::string> accepted;  ///< names accepted at this place, where that is a short list
  int source =
      -1;  ///< the text among those that Diagnostics knows, of which several may have one name
};

/// A place in a text that Diagnostics knows.
struct Mark {
  int source = -1;  ///< index into Diagnostics' texts, −1: none
  int line = 0;
  int column = 0;
};

/// A place in an input together with its key path.
struct Place {
  Mark mark;
  std::string path;
};

/// A value and where it was written.
template <class T>
struct Located {
  T value{};
  Place place;
};
using Name = Located<std::string>;

/// A file that was read.
struct InputFile {
  std::string file;
  std::string sha256;  ///< of its bytes
};

/// Collects diagnostics, the texts that they point into, and what data files were read.
class Diagnostics {
 public:
  /// Errors beyond this are only counted.
  static constexpr int kMaxErrors = 100;

  /// Makes a text known; returns its index for Mark::source.
  int add_source(std::string name, std::string text);
  const std::string& source_name(int source) const { return sources_[source]->name; }
  /// One line of a text (from 1), without its end.
  std::string_view line(int source, int number) const { return sources_[source]->line(number); }
  /// Converts a byte offset in a line (0-based, as yaml-cpp has it) into a 1-based character.
  int character_column(int source, int line, int byte) const;

  void error(const Place& place, std::string message, std::string hint = {},
             std::vector<std::string> accepted = {});
  void warning(const Place& place, std::string message, std::string hint = {});
  void note(const Place& place, std::string message, std::string hint = {});
  void add(Diagnostic diagnostic);

  const std::vector<Diagnostic>& list() const { return list_; }
  bool has_errors() const { return errors_ > 0; }
  int error_count() const { return errors_; }
  /// Remembers a data file, once.
  void add_data_file(InputFile file);
  const std::vector<InputFile>& data_files() const { return data_files_; }
  /// The line of a text or file at which a diagnostic points, empty if there is none.
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

/// The diagnostics as a compiler prints them: `file:line:column: error: message`, the source line,
/// a caret, and a hint. Leaves out what is less severe than `least`; errors beyond the limit are
/// only counted. Nothing is longer than `width` characters, unless that is 0.
std::string format_diagnostics(const Diagnostics& diagnostics, bool colour,
                               Severity least = Severity::kNote, int limit = 20, int width = 0);

}  // namespace conddp
