#pragma once

#include "problem_file/model/spec_cost.hpp"
#include "problem_file/values/key_forms.hpp"

namespace conddp {

/// Activations in the order of the documents.
inline constexpr Choice<ActivationKind> kActivationWords[] = {
    {"quadratic", ActivationKind::quadratic, "½ Σ w r²"},
    {"quadratic_barrier", ActivationKind::quadratic_barrier,
     "½ Σ w r² of what lies outside bounds; needs 'lower', 'upper' or 'from: urdf'"},
    {"smooth_l1", ActivationKind::smooth_l1, "Σ w (√(r² + ε²) − ε); takes 'epsilon'"},
    {"smooth_l2", ActivationKind::smooth_l2, "√(Σ w r² + ε²) − ε; takes 'epsilon'"},
    {"linear", ActivationKind::linear, "Σ w r, a cost that can be negative"}};

/// True for activations that accept some of the keys.
inline bool has_keys(ActivationKind kind) {
  return kind != ActivationKind::quadratic && kind != ActivationKind::linear;
}

/// The keys of an activation. Those that its kind does not have are omitted.
void describe(Keys& keys, ActivationSpec& activation);

/// A name, or a mapping with the keys of the activation.
struct ActivationForm {
  bool read(const YamlReader& reader, ActivationSpec& activation) const;
  std::optional<OrderedJson> expand(const ActivationSpec& activation) const;
  OrderedJson schema(const ActivationSpec& value, SchemaDefinitions& definitions) const;
};

}  // namespace conddp
