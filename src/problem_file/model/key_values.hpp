#pragma once

#include <algorithm>
#include <any>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace conddp {

/// A key of a problem file, the type of its value, and the default for a missing key, if any.
template <class T>
struct Key {
  std::string_view name;
  std::optional<T> fallback = {};
};

/// Values of keys that only some terms have.
class KeyValues {
 public:
  /// Null if the key is missing.
  template <class T>
  const T* find(const Key<T>& key) const {
    for (const auto& [name, value] : values_)
      if (name == key.name) return std::any_cast<T>(&value);
    return nullptr;
  }
  /// The key's fallback if the key is missing, or a new value.
  template <class T>
  T value(const Key<T>& key) const {
    const T* found = find(key);
    return found != nullptr ? *found : key.fallback.value_or(T{});
  }
  bool has(std::string_view name) const {
    return std::any_of(values_.begin(), values_.end(),
                       [&](const auto& entry) { return entry.first == name; });
  }
  template <class T>
  void set(const Key<T>& key, T value) {
    for (auto& [name, former] : values_)
      if (name == key.name) {
        former = std::move(value);
        return;
      }
    values_.emplace_back(key.name, std::move(value));
  }

 private:
  std::vector<std::pair<std::string_view, std::any>> values_;
};

}  // namespace conddp
