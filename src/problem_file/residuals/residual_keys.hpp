#pragma once

#include <string>
#include <vector>

#include "problem_file/model/residual_definition.hpp"
#include "problem_file/values/key_forms.hpp"

namespace conddp {

/// Rows of residuals on positions: m.
inline const std::vector<std::string> kPositionNames = {"x", "y", "z"};
/// Rows of residuals on velocities of frames and contacts: m/s, rad/s.
inline const std::vector<std::string> kTwistNames = {"vx", "vy", "vz", "wx", "wy", "wz"};

/// The name of the preceding knot's control in expressions, indexed by component.
inline constexpr std::string_view kPreviousControl = "previous";

namespace detail {

/// The value of a key of a cost.
template <class T, class Form>
struct CostValue final : KeyValue {
  CostValue(const Key<T>& its_key, const Form& its_form, CostSpec& its_cost)
      : key(its_key), form(its_form), cost(its_cost) {}
  void read(const YamlReader& reader) override {
    T value = cost.keys.value(key);
    if (read_as(form, reader, value)) cost.keys.set(key, std::move(value));
  }
  std::optional<OrderedJson> expand() const override {
    if (const T* value = cost.keys.find(key)) return expand_as(form, *value);
    return expand_as(form, key.fallback);
  }
  OrderedJson schema(SchemaDefinitions& definitions) const override {
    return schema_as(form, key.fallback, definitions);
  }
  bool has_default() const override {
    return requires { form.schema(); };
  }

  const Key<T>& key;
  const Form& form;
  CostSpec& cost;
};

}  // namespace detail

/// A residual's key whose value has a form of key_forms.hpp. The name of `info` is that of the key.
template <class T, class Form>
ResidualKey residual_key(const Key<T>& key, KeyInfo info, const Form& form, KeyTraits traits = {}) {
  info.name = key.name;
  return {info, traits, [&key, form](Keys& keys, const KeyInfo& own, CostSpec& cost) {
            detail::CostValue<T, Form> value(key, form, cost);
            keys.visit(own, value);
          }};
}

/// The key `contacts` of residuals on contacts.
const ResidualKey& contacts_key();
/// The rows of a combination as factors, or of a residual as expressions.
const ResidualKey& rows_key();

/// Describes `residual`, explained by `says`, and the keys that belong to residuals. False for an
/// unknown residual.
bool describe_residual(Keys& keys, CostSpec& cost, std::string_view says);
/// True if a key of the cost's residual replaces another key.
bool is_excluded(std::string_view key, const CostSpec& cost);
/// Sets the keys of the residual that have defaults of their own in this problem.
void complete_residual(CostSpec& cost, const TermContext& context);

}  // namespace conddp
