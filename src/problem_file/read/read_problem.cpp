#include "problem_file/read/read_problem.hpp"

#include "base/files/check_sums.hpp"
#include "base/files/text_file.hpp"
#include "problem_file/lower/rewriting.hpp"
#include "problem_file/lower/similar_names.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/yaml_source.hpp"

namespace conddp {

namespace {

ProblemSpec read_document(const YamlReader& root, const std::filesystem::path& file,
                          ExpressionNamesSpec names) {
  const std::filesystem::path folder = file.parent_path();
  const YamlReader reader(root.node(), {}, root.diagnostics(), &folder);
  ProblemSpec spec;
  spec.file = file;
  spec.name = {file.stem().string(), reader.place()};
  spec.names = std::move(names);
  YamlMap map(reader);
  KeyReader keys(map);
  describe(keys, spec);
  return spec;
}

}  // namespace

std::optional<ProblemDocument> parse_problem(std::string text, const std::filesystem::path& file,
                                             Diagnostics& out) {
  const int source = out.add_source(file.string(), text);
  std::optional<YamlNode> root = parse_yaml(text, source, out);
  if (!root) return std::nullopt;
  if (root->find("conddp_batch") != nullptr && root->find("conddp") == nullptr) {
    out.error({root->mark, {}}, "this is a plan of a batch, not a problem file",
              "'conddp batch run' takes it");
    return std::nullopt;
  }
  return ProblemDocument{file, std::move(text), {}, *std::move(root)};
}

std::optional<ProblemDocument> load_problem(const std::filesystem::path& file, const Place& place,
                                            Diagnostics& out) {
  std::string hash;
  std::optional<std::string> text = read_text(file, kMaxYamlBytes, place, hash, out);
  if (!text) return std::nullopt;
  auto document = parse_problem(*std::move(text), file, out);
  if (document) document->sha256 = hash;
  return document;
}

namespace {

/// Applies settings and the rewritings of the document, up to the one named `last`.
std::optional<DocumentDraft> rewrite(const ProblemDocument& document,
                                     const std::vector<Setting>& settings, double homotopy_share,
                                     std::string_view last, Diagnostics& out) {
  DocumentDraft draft{.root = document.root, .names = {}, .homotopy_share = homotopy_share};
  for (const Setting& setting : settings) apply_setting(draft.root, setting, out);
  for (const DocumentRewriting& rewriting : document_rewritings()) {
    if (out.has_errors()) return std::nullopt;
    rewriting.apply(draft, out);
    if (rewriting.name == last) break;
  }
  if (out.has_errors()) return std::nullopt;
  return draft;
}

std::optional<ProblemSpec> read_with_settings(const ProblemDocument& document,
                                              const std::vector<Setting>& settings,
                                              double homotopy_share, std::string_view last,
                                              Diagnostics& out) {
  auto draft = rewrite(document, settings, homotopy_share, {}, out);
  if (!draft) return std::nullopt;
  ProblemSpec spec =
      read_document(YamlReader(draft->root, {}, out), document.file, std::move(draft->names));
  for (const SpecRewriting& rewriting : spec_rewritings()) {
    if (out.has_errors()) return std::nullopt;
    rewriting.apply(spec, out);
    if (rewriting.name == last) break;
  }
  if (out.has_errors()) return std::nullopt;
  spec.text = document.text;
  spec.sha256 = document.sha256.empty() ? sha256(document.text) : document.sha256;
  spec.definition = canonical_definition(draft->root);
  for (const Setting& setting : settings) spec.settings.push_back(setting.text);
  return spec;
}

}  // namespace

std::optional<ProblemSpec> read_problem(const ProblemDocument& document,
                                        const std::vector<Setting>& settings, Diagnostics& out,
                                        const ReadOptions& options) {
  const Diagnostics before = settings.empty() ? Diagnostics() : out;
  auto spec = read_with_settings(document, settings, options.homotopy_share, options.last, out);
  if (!spec && !settings.empty()) out = with_similar_names(out, before, document.root, settings);
  return spec;
}

std::optional<ProblemSpec> read_problem(const std::optional<ProblemDocument>& document,
                                        const std::vector<std::string>& overrides, Diagnostics& out,
                                        const ReadOptions& options) {
  if (!document) return std::nullopt;
  return read_problem(*document, parse_settings(overrides, out), out, options);
}

std::optional<ProblemSpec> read_problem_text(const std::string& text,
                                             const std::filesystem::path& file,
                                             const std::vector<std::string>& overrides,
                                             Diagnostics& out, const ReadOptions& options) {
  return read_problem(parse_problem(text, file, out), overrides, out, options);
}

std::optional<YamlNode> rewritten_document(const std::string& text,
                                           const std::filesystem::path& file,
                                           const std::vector<std::string>& overrides,
                                           std::string_view rewriting, Diagnostics& out) {
  const auto document = parse_problem(text, file, out);
  if (!document) return std::nullopt;
  auto draft = rewrite(*document, parse_settings(overrides, out), 1, rewriting, out);
  return draft ? std::optional(std::move(draft->root)) : std::nullopt;
}

std::optional<ProblemSpec> read_problem(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides,
                                        Diagnostics& out) {
  return read_problem(load_problem(file, {}, out), overrides, out);
}

}  // namespace conddp
