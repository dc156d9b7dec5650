#pragma once

#include <span>
#include <string_view>

#include "problem_file/model/spec.hpp"
#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// State of a document between two rewritings.
struct DocumentDraft {
  YamlNode root;
  ExpressionNamesSpec names;
  double homotopy_share = 1;  ///< of the path of a homotopy
};

/// Rewriting of a document before it is read.
struct DocumentRewriting {
  std::string_view name;  ///< as in `check --expand NAME`
  void (*apply)(DocumentDraft& draft, Diagnostics& out);
};

/// Rewriting of a specification before it is built.
struct SpecRewriting {
  std::string_view name;
  void (*apply)(ProblemSpec& spec, Diagnostics& out);
};

/// Rewritings from the problem as its file says it to the problem that is built, in their order.
/// Each stands for a feature that nothing after it knows.
std::span<const DocumentRewriting> document_rewritings();
std::span<const SpecRewriting> spec_rewritings();

}  // namespace conddp
